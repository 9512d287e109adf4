#include "tests/conformance/shift.h"

#include <cmath>

#include <fmt/format.h>

namespace sunder::conformance {
namespace {

// A contact found late overlaps at most by the distance that the surfaces close in a window. Removing the overlap moves
// the bodies by this distance, which is the arm of the relative momentum. The tolerance of bodies at rest is added
// (resting.cpp).
constexpr double kOverlap_m = 1e-4;

}  // namespace

Shift shift(const Play& play, const Motions& before, const Vec3& about, double window_s) {
  Shift out;
  Vec3 way = Vec3::Zero(), apart = Vec3::Zero();
  double sign = 1.0;
  for (const link::Motion& given : play.predicted()) {
    const RigidBody& b = play.body(given.id);
    const BodyMotion &now = b.motion, &hb = given.motion;
    const Vec3 moved = (now.position - hb.position) - window_s * (now.velocity - hb.velocity);
    out.change += b.mass * ((now.position - about).cross(now.velocity) - (hb.position - about).cross(hb.velocity)) +
                  (now.angular_momentum - hb.angular_momentum);
    out.moved += moved.cross(b.mass * now.velocity);
    way += sign * (now.position - before.at(given.id).position), apart += sign * moved;
    sign = -1.0;
  }
  out.apart = apart.norm();
  out.rest = way.norm() > 0.0 ? std::abs((out.change - out.moved).dot(way.normalized())) : 0.0;
  return out;
}

ShiftRows::ShiftRows(const Play& play, double window_s, double reach_m)
    : centre_(play.centre_of_mass()), start_(play.angular_momentum(centre_)), window_s_(window_s) {
  const RigidBody &a = play.body(1), &b = play.body(2);
  const double relative = (a.motion.velocity - b.motion.velocity).norm();
  const double closing = relative + reach_m * (a.angular_velocity().norm() + b.angular_velocity().norm());
  allowed_ = (window_s * closing + kOverlap_m) * relative * a.mass * b.mass / (a.mass + b.mass);
}

void ShiftRows::before(const Play& play) { before_ = {{1, play.body(1).motion}, {2, play.body(2).motion}}; }

void ShiftRows::after(const Play& play) {
  const Shift now = shift(play, before_, centre_, window_s_);
  moved_ += now.moved, apart_ += now.apart, rest_ += now.rest;
}

void ShiftRows::judge(const Play& play, Report& report, double unit, double exact) const {
  report.check("angular", (play.angular_momentum(centre_) - start_).norm() / unit, 0.0, allowed_ / unit,
               fmt::format("{:.1e} of it by poses moved, {:.2g} mm in all", moved_.norm() / unit, 1e3 * apart_));
  report.check("angular_rest", rest_ / unit, 0.0, exact, "part not due to moved poses, along the relative motion");
}

}  // namespace sunder::conformance
