#include "shell/soft/soft_proxy.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>
#include <Eigen/Geometry>

namespace sunder::shell {
namespace {

constexpr int kSweeps = 20;                // of Gauss-Seidel, at most
constexpr double kSettled = 1e-10;         // change of the impulses in a sweep, of their sum, at which it ends
constexpr double kFastestRecovery = 0.01;  // of an overlap [m/s], as a shell's
constexpr double kRecovery = 0.1;          // of an overlap, taken back in a step
constexpr double kWatch = 0.02;            // of a grid spacing: what comes so near may be pushed in by its neighbours

constexpr int kSeen = kNodes * kNodes * kNodes;

// One point that may press on a body.
struct Press {
  std::size_t body, copy;
  const SoftSurface* face;
  Vec3 x, normal;  // out of the body
  double wanted;   // least normal velocity afterwards [m/s]
  double friction;
  std::array<std::size_t, kSeen> node;
  std::array<double, kSeen> weight;
  double own, along, across;  // inverse masses: of the nodes, of both along the normal and across it [1/kg]
  Vec3 impulse = Vec3::Zero();
  Vec3 before;  // relative velocity before all impulses [m/s]
};

Vec3 of_nodes(const Press& c, const std::vector<Vec3>& a) {
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < kSeen; ++k) sum += c.weight[k] * a[c.node[k]];
  return sum;
}

// Gauss-Seidel on velocities of copies: the true bodies take what is found at the end, once.
void solve(const SoftState& s, std::vector<Press>& presses, std::vector<Proxy>& copies, std::vector<Vec3>& v) {
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double changed = 0.0, sum = 0.0;
    for (Press& c : presses) {
      Proxy& body = copies[c.copy];
      const Vec3 rel = of_nodes(c, v) - body.velocity_at(c.x);
      const double approach = rel.dot(c.normal), old = c.impulse.dot(c.normal);
      const double pushed = std::max(0.0, old + (c.wanted - approach) / c.along);
      Vec3 slide = c.impulse - old * c.normal - (rel - approach * c.normal) / c.across;
      const double most = c.friction * pushed, size = slide.norm();
      if (size > most) slide *= most / size;
      const Vec3 change = pushed * c.normal + slide - c.impulse;
      c.impulse += change;
      for (int k = 0; k < kSeen; ++k)
        if (c.weight[k] != 0.0) v[c.node[k]] += (c.weight[k] / s.grid.mass[c.node[k]]) * change;
      if (!body.body.is_static) body.apply(c.x, -change);
      changed += change.norm(), sum += c.impulse.norm();
    }
    if (changed <= kSettled * sum) return;
  }
}

}  // namespace

int press_on_bodies(const SoftModel& m, SoftState& s, std::vector<Proxy>& bodies, const std::vector<double>& friction,
                    double dt) {
  std::vector<Vec3> points;
  Eigen::AlignedBox3d box;
  for (const SoftSurface& face : m.surface) points.push_back(s.surface_point(face)), box.extend(points.back());
  double speed = 0.0;
  for (const Vec3& v : s.v) speed = std::max(speed, v.squaredNorm());
  speed = std::sqrt(speed);
  std::vector<Press> presses;
  std::vector<Proxy> copies;  // of what may be pressed on
  std::size_t copy_of = bodies.size();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Proxy& body = bodies[b];
    const double margin = kWatch * m.grid;
    if (std::isfinite(body.radius())) {
      const double turning = body.body.is_static ? 0.0 : body.body.angular_velocity().norm() * body.radius();
      const double reach = body.radius() + margin + dt * (speed + body.body.motion.velocity.norm() + turning);
      if (box.squaredExteriorDistance(body.body.motion.position) > reach * reach) continue;
    }
    for (std::size_t i = 0; i < m.surface.size(); ++i) {
      const Proxy::Distance gap = body.distance(points[i]);
      const int particle = m.surface[i].particle;
      if (gap.value > margin + dt * (s.v[particle] - body.velocity_at(points[i])).norm()) continue;
      Press c;
      if (copy_of != b) copies.push_back(body), copy_of = b;
      c.body = b, c.copy = copies.size() - 1, c.face = &m.surface[i], c.x = points[i], c.normal = gap.normal,
      c.friction = friction[body.body.contact_group];
      int k = 0;
      c.own = 0.0;
      s.each_surface_node(m, m.surface[i], [&](std::size_t node, double w, const double*) {
        c.node[k] = node, c.weight[k] = s.grid.mass[node] > 0.0 ? w : 0.0;
        if (c.weight[k++] != 0.0) c.own += w * w / s.grid.mass[node];
      });
      c.before = of_nodes(c, s.grid.v) - body.velocity_at(c.x);
      // what is in keeps its overlap, but for what is taken back slowly, or as the engine's rows need it
      const double share = std::max(kRecovery, body.recovery);
      c.wanted = gap.value > 0.0 ? -gap.value / dt : std::min(share * -gap.value / dt, kFastestRecovery);
      if (c.before.dot(c.normal) > c.wanted + margin / dt) continue;
      const Mat3 theirs = body.inverse_mass_at(c.x);
      const double along = c.normal.dot(theirs * c.normal);
      c.along = c.own + along, c.across = c.own + theirs.trace() - along;
      presses.push_back(c);
    }
  }
  if (presses.empty()) return 0;
  std::vector<Vec3> v = s.grid.v;
  solve(s, presses, copies, v);
  int touching = 0;
  for (const Press& c : presses) {
    if (c.impulse.isZero(0.0)) continue;
    ++touching;
    Proxy& body = bodies[c.body];
    s.each_surface_node(m, *c.face, [&](std::size_t node, double w, const double* offset) {
      if (s.grid.mass[node] <= 0.0) return;
      s.grid.v[node] += (w / s.grid.mass[node]) * c.impulse;
      const Vec3 arm = s.x[c.face->particle] + Vec3(offset[0], offset[1], offset[2]) - body.body.motion.position;
      body.shell_linear += w * c.impulse, body.shell_angular += arm.cross(w * c.impulse);
      body.moment_sum += arm.norm() * std::abs(w) * c.impulse.norm();
    });
    body.impulse_sum += c.impulse.norm();
    body.apply(c.x, -c.impulse);
  }
  for (const Press& c : presses)
    if (!c.impulse.isZero(0.0)) {
      const Vec3 after = of_nodes(c, s.grid.v) - bodies[c.body].velocity_at(c.x);
      // on the mean of the velocities before the kick and after contact
      s.book.contact -= c.impulse.dot(0.5 * (c.before + after) - 0.25 * (s.dt + dt) * of_nodes(c, s.grid.acceleration));
    }
  return touching;
}

}  // namespace sunder::shell
