#include "shell/soft/soft_proxy.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <Eigen/Dense>
#include <Eigen/Geometry>

namespace sunder::shell {
namespace {

constexpr int kPressNodes = std::tuple_size_v<decltype(BodyPress::node)>;

Vec3 of_nodes(const BodyPress& c, const std::vector<Vec3>& a) {
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < kPressNodes; ++k) sum += c.weight[k] * a[c.node[k]];
  return sum;
}

// Solves on copies of bodies and velocities. The true bodies receive the total impulses once, at the end.
void solve(const SoftState& s, std::vector<BodyPress>& presses, std::vector<Proxy>& copies, std::vector<Vec3>& v) {
  for (int sweep = 0; sweep < kPressSweeps; ++sweep) {
    double changed = 0.0, sum = 0.0;
    for (BodyPress& c : presses) {
      Proxy& body = copies[c.copy];
      const Vec3 rel = of_nodes(c, v) - body.velocity_at(c.x);
      const Vec3 change = press(rel, c.normal, c.wanted, c.friction, c.along, c.across, c.impulse);
      for (int k = 0; k < kPressNodes; ++k)
        if (c.weight[k] != 0.0) v[c.node[k]] += (c.weight[k] / s.grid.mass[c.node[k]]) * change;
      if (body.is_free()) body.apply(c.x, -change);
      changed += change.norm(), sum += c.impulse.norm();
    }
    if (changed <= kPressSettled * sum) return;
  }
}

}  // namespace

int press_on_bodies(const SoftModel& m, SoftState& s, std::vector<Proxy>& bodies, const std::vector<double>& friction,
                    double dt, PressScratch& scratch) {
  auto& [points, v, presses, copies] = scratch;  // copies: only of bodies that may be touched
  points.clear(), presses.clear(), copies.clear();
  Eigen::AlignedBox3d box;
  for (const SoftSurface& face : m.surface) points.push_back(s.surface_point(face)), box.extend(points.back());
  double speed = 0.0;
  for (const Vec3& one : s.v) speed = std::max(speed, one.squaredNorm());
  speed = std::sqrt(speed);
  std::size_t copy_of = bodies.size();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Proxy& body = bodies[b];
    const double margin = kPressWatch * m.grid;
    if (std::isfinite(body.radius())) {
      const double reach =
          body.radius() + margin + dt * (speed + body.body.motion.velocity.norm() + body.turning_speed());
      if (box.squaredExteriorDistance(body.body.motion.position) > reach * reach) continue;
    }
    for (std::size_t i = 0; i < m.surface.size(); ++i) {
      const Proxy::Distance gap = body.distance(points[i]);
      const int particle = m.surface[i].particle;
      if (gap.value > margin + dt * (s.v[particle] - body.velocity_at(points[i])).norm()) continue;
      BodyPress c;
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
      // An overlap is taken back slowly, or as fast as rows of the engine ask for.
      c.wanted = wanted_velocity(gap.value, dt, dt, std::max(kPressRecovery, body.recovery));
      if (c.before.dot(c.normal) > c.wanted + margin / dt) continue;
      const Mat3 theirs = body.inverse_mass_at(c.x);
      const double along = c.normal.dot(theirs * c.normal);
      c.along = c.own + along, c.across = c.own + theirs.trace() - along;
      presses.push_back(c);
    }
  }
  if (presses.empty()) return 0;
  v = s.grid.v;
  solve(s, presses, copies, v);
  int touching = 0;
  for (const BodyPress& c : presses) {
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
  for (const BodyPress& c : presses)
    if (!c.impulse.isZero(0.0)) {
      const Vec3 after = of_nodes(c, s.grid.v) - bodies[c.body].velocity_at(c.x);
      // Work is booked on the mean of the velocities before the kick and after contact.
      s.book.contact -= c.impulse.dot(0.5 * (c.before + after) - 0.25 * (s.dt + dt) * of_nodes(c, s.grid.acceleration));
      s.book.external += bodies[c.body].work(c.x, c.impulse);
    }
  return touching;
}

}  // namespace sunder::shell
