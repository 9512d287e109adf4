#include "shell/solver/contact/hertz.h"

#include <cmath>
#include <limits>

#include "coupler/core/error.h"
#include "shell/solver/contact/rigid_contact.h"

namespace sunder::shell {
namespace {

constexpr double kContactSteps = 20.0;  // factor on the contact's frequency squared: a contact lasts about 3 / omega
constexpr int kSearches = 4;  // searches for the nearest point, each by Newton's method on a quadratic surface
constexpr int kNewtonSteps = 4;

Vec3 sum_of(const std::vector<double>& field, const ShellState& s, const std::vector<GatheredFunction>& functions,
            int derivative) {
  Vec3 sum = Vec3::Zero();
  for (const auto& f : functions) sum += f.n[derivative] * s.at(field, f.slot);
  return sum;
}

// Returns the step in the parameters, within `low` and `high`, to the point nearest to `to`. `functions` describe the
// surface to second order.
Vec2 nearest_step(const ShellState& s, const std::vector<GatheredFunction>& functions, const Vec3& to, const Vec2& low,
                  const Vec2& high) {
  Vec3 d[6];
  for (int k = 0; k < 6; ++k) d[k] = sum_of(s.motion.x, s, functions, k);
  Vec2 p = Vec2::Zero();
  for (int i = 0; i < kNewtonSteps; ++i) {
    const double u = p.x(), v = p.y();
    const Vec3 r = d[0] + u * d[1] + v * d[2] + 0.5 * u * u * d[3] + 0.5 * v * v * d[4] + u * v * d[5] - to;
    const Vec3 xu = d[1] + u * d[3] + v * d[5], xv = d[2] + v * d[4] + u * d[5];
    Eigen::Matrix2d hessian;
    hessian(0, 0) = xu.dot(xu) + r.dot(d[3]), hessian(1, 1) = xv.dot(xv) + r.dot(d[4]);
    hessian(0, 1) = hessian(1, 0) = xu.dot(xv) + r.dot(d[5]);
    if (hessian.determinant() <= 0.1 * xu.squaredNorm() * xv.squaredNorm())  // as curved as the sphere
      hessian << xu.dot(xu), xu.dot(xv), xu.dot(xv), xv.dot(xv);
    const Vec2 step = hessian.ldlt().solve(Vec2(r.dot(xu), r.dot(xv)));
    if (!step.allFinite()) break;
    p = (p - step).cwiseMax(low).cwiseMin(high);
  }
  return p;
}

struct Touch {
  Vec3 x, out;            // point of the mid-surface; direction away from the sphere
  double approach = 0.0;  // [m]; not positive: no contact
};

// Finds the point of the surface nearest to the sphere, its functions and the approach. Beside a crack, the nearest
// sample's own functions continue the surface, as far as that sample sees.
Touch find(const ShellModel& m, const ShellState& s, const Proxy& body, double radius,
           const std::vector<ContactCandidates::Sample>& candidates, std::vector<GatheredFunction>& functions) {
  const Vec3 centre = body.body.motion.position;
  double nearest = std::numeric_limits<double>::infinity();
  const ContactCandidates::Sample* best = nullptr;
  for (const auto& candidate : candidates) {
    sample_functions(m, s, candidate.block, candidate.lane, functions);
    if (functions.empty() || s.motion.detached[functions[0].slot]) continue;
    const double distance = (sum_of(s.motion.x, s, functions, 0) - centre).squaredNorm();
    if (distance < nearest) nearest = distance, best = &candidate;
  }
  Touch touch;
  if (!best) return touch;
  const Vec2 begin(m.patch.knots_u.begin(), m.patch.knots_v.begin()), end(m.patch.knots_u.end(), m.patch.knots_v.end());
  const Vec2 reach(m.spacing_u, m.spacing_v);
  const Vec2 from = gauss_point(m.patch, m.tables, best->block, best->lane).parameter;
  const int point = s.cracked.point_of[static_cast<std::size_t>(best->block) * m.tables.lanes + best->lane];
  const double thick = m.tables.thickness_factor(best->block, best->lane);
  bool crack = point >= 0;
  s.cracks.graph.near(from, from, 3.0 * m.spacing, [&](int) { return !(crack = true); });
  if (crack) {
    if (point >= 0)
      functions = s.cracked.gathered[point].functions, thicken(functions, 1.0 / thick);
    else
      patch_functions(m.patch, from, m.tables.stride, functions);
    Vec2 p = nearest_step(s, functions, centre, (begin - from).cwiseMax(-reach), (end - from).cwiseMin(reach));
    for (int i = 0; i < 6 && !s.cracks.graph.visible(from, from + p); ++i) p *= 0.5;
    if (!s.cracks.graph.visible(from, from + p)) p.setZero();
    for (auto& f : functions)
      f.n[0] += p.x() * f.n[1] + p.y() * f.n[2] + 0.5 * p.x() * p.x() * f.n[3] + 0.5 * p.y() * p.y() * f.n[4] +
                p.x() * p.y() * f.n[5];
  } else {
    Vec2 at = from;
    for (int i = 0; i < kSearches; ++i) {
      patch_functions(m.patch, at, m.tables.stride, functions);
      at += nearest_step(s, functions, centre, (begin - at).cwiseMax(-reach), (end - at).cwiseMin(reach));
    }
    patch_functions(m.patch, at, m.tables.stride, functions);
  }
  touch.x = sum_of(s.motion.x, s, functions, 0);
  const Vec3 away = touch.x - centre;
  const double distance = away.norm();
  if (distance == 0.0) return touch;
  touch.out = away / distance, touch.approach = radius + 0.5 * thick * m.thickness - distance;
  return touch;
}

std::vector<GatheredFunction>& scratch() {
  thread_local std::vector<GatheredFunction> functions;
  return functions;
}

}  // namespace

bool hertz_contact(const ShellModel& m, ShellState& s, Proxy& body, double stiffness,
                   const std::vector<ContactCandidates::Sample>& candidates, double dt) {
  const auto* sphere = std::get_if<SphereShape>(&body.body.shape);
  if (!sphere) return false;
  std::vector<GatheredFunction>& functions = scratch();
  const Touch touch = find(m, s, body, sphere->radius, candidates, functions);
  if (!(touch.approach > 0.0)) return false;
  if (touch.approach > kDeepestApproach * sphere->radius) {
    Error e(
        Exit::kPhysics, "hertz",
        fmt::format("body '{}' has sunk {:.3g} m into shell '{}' ({:.3g} of its radius): Hertz's law is for less than "
                    "{} of it; take a higher hertz stiffness, a lower speed, or leave hertz out",
                    body.body.name, touch.approach, m.name, touch.approach / sphere->radius, kDeepestApproach));
    e.body = body.body.name;
    throw e;
  }
  const Vec3 j = (dt * stiffness * touch.approach * std::sqrt(touch.approach)) * touch.out;
  apply_impulse(s, body, functions, touch.x, j);
  s.book.external += body.work(touch.x, j);
  return true;
}

double hertz_energy(const ShellModel& m, const ShellState& s, const std::vector<Proxy>& bodies,
                    const std::vector<ContactCoefficients>& coefficients, const ContactCandidates& candidates,
                    double dt) {
  double sum = 0.0;
  for (std::size_t b = 0; b < candidates.of_body.size() && b < coefficients.size(); ++b) {
    const auto* sphere = std::get_if<SphereShape>(&bodies[b].body.shape);
    if (coefficients[b].hertz == 0.0 || !sphere) continue;
    std::vector<GatheredFunction>& functions = scratch();
    const Touch touch = find(m, s, bodies[b], sphere->radius, candidates.of_body[b], functions);
    if (!(touch.approach > 0.0)) continue;
    const double force = coefficients[b].hertz * touch.approach * std::sqrt(touch.approach);
    const Vec3 apart = sum_of(s.motion.v, s, functions, 0) - bodies[b].velocity_at(touch.x);
    sum += 0.4 * force * touch.approach + 0.5 * dt * force * touch.out.dot(apart);
  }
  return sum;
}

double hertz_approach(double mass, double stiffness, double speed) {
  return std::pow(1.25 * mass * speed * speed / stiffness, 0.4);  // from m v^2 / 2 = 2/5 k d^(5/2)
}

double hertz_step(const ShellModel& m, const RigidBody& sphere, double stiffness, double speed, double step) {
  const double inverse = m.largest_mobility + (sphere.is_static ? 0.0 : 1.0 / sphere.mass);
  const double approach = hertz_approach(1.0 / inverse + sphere.mass, stiffness, speed);
  const double rate = 1.5 * stiffness * std::sqrt(approach) * inverse;
  return 2.0 / std::sqrt(4.0 / (step * step) + kContactSteps * kContactSteps * rate);
}

}  // namespace sunder::shell
