#include "shell/run/flight.h"

#include <algorithm>
#include <cmath>

namespace sunder::shell {
namespace {

// Largest approach of two bodies that can meet in a window without a shell, as a share of the thickness. A longer
// window would depend on how far an engine looks ahead for contacts, which differs between engines.
constexpr double kSettleTravel = 1.25;
constexpr int kRigidSubsteps = 4;  // steps of free flight in a window without a shell

}  // namespace

bool meets_box(const Eigen::AlignedBox3d& box, double pad, const Vec3& position, const Vec3& velocity, double time) {
  double from = 0.0, to = time;  // times at which the path is in the box
  for (int d = 0; d < 3; ++d) {
    const double low = box.min()[d] - pad - position[d], high = box.max()[d] + pad - position[d];
    const double v = velocity[d];
    if (v == 0.0 && (low > 0.0 || high < 0.0)) to = -1.0;
    if (v == 0.0) continue;
    from = std::max(from, std::min(low / v, high / v)), to = std::min(to, std::max(low / v, high / v));
  }
  return from <= to;
}

bool passes(const Vec3& point, double reach, const Vec3& position, const Vec3& velocity, double time) {
  const Vec3 to = point - position;
  const double speed2 = velocity.squaredNorm();
  const double nearest = speed2 > 0.0 ? std::clamp(to.dot(velocity) / speed2, 0.0, std::max(0.0, time)) : 0.0;
  return (to - nearest * velocity).squaredNorm() <= reach * reach;
}

std::int64_t rigid_window_ticks(const RunSetup& setup, const std::vector<Proxy>& bodies) {
  const auto most = static_cast<std::int64_t>(std::llround(setup.settle_window / setup.tick));
  if (setup.shells.empty() || most <= 1) return most;
  double thickness = setup.shells[0].model.least_thickness();
  for (const ShellSetup& s : setup.shells) thickness = std::min(thickness, s.model.least_thickness());
  const double travel = kSettleTravel * thickness;
  double longest = setup.settle_window;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const RigidBody& a = bodies[i].body;
    if (!std::isfinite(bodies[i].radius())) continue;  // no body passes through a half space
    for (std::size_t j = 0; j < i; ++j) {
      const RigidBody& b = bodies[j].body;
      if (!std::isfinite(bodies[j].radius()) || (a.is_static && b.is_static)) continue;
      const double gap = (a.motion.position - b.motion.position).norm() - bodies[i].radius() - bodies[j].radius();
      double speed = (a.motion.velocity - b.motion.velocity).norm();
      for (const Proxy* p : {&bodies[i], &bodies[j]})  // it may speed up within the window
        if (p->is_driven() && !p->has_arrived()) speed += p->top_speed();
      if (speed * longest <= travel || gap > speed * longest) continue;
      longest = std::max(travel / speed, setup.tick);
    }
  }
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(longest / setup.tick * (1.0 + 1e-9)));
}

void free_fall(std::vector<Proxy>& bodies, std::size_t count, const Vec3& gravity, double time, double window) {
  const double h = window / kRigidSubsteps;
  for (std::size_t i = 0; i < count; ++i) {
    bodies[i].drive(time, window), bodies[i].arrive(time + window);
    for (int k = 0; k < kRigidSubsteps && bodies[i].is_free(); ++k) {
      Proxy& p = bodies[i];
      p.body.motion.velocity += h * gravity;
      p.body.drift(h);
      p.body.motion.position -= 0.5 * h * h * gravity;  // exact: position moves with the mean of both velocities
    }
  }
}

}  // namespace sunder::shell
