// The ledger: each body must have gained what the shells lost. It is checked in every window and at every birth.
#include <algorithm>
#include <cmath>

#include "coupler/core/error.h"
#include "shell/run/coupler.h"

namespace sunder::shell {
namespace {

// Relative to the sum of |J|, plus the body's momentum for its gain. Double precision leaves some 1e-15.
constexpr double kLedgerTolerance = 1e-12;
// each substep may leave a rounding error; with more of them the tolerance grows in proportion
constexpr double kSubstepsRounded = 4000.0;
constexpr double kSingleTolerance = 1e-4;  // for engines that declare single precision, as in the conformance suite

// absolute where the scale is zero
double relative(double error, double scale) { return scale > 0.0 ? error / scale : error; }

// NaN exceeds all, and nothing exceeds it
bool exceeds(double a, double b) { return std::isnan(a) || a > b; }

// the larger one; NaN where either is
double worse(double a, double b) { return exceeds(a, b) ? a : b; }

}  // namespace

void Coupler::check_ledger(double window, double dt) {
  if (tamper_) tamper_(clock_.windows, state_.bodies);
  const double roundings = std::max(1.0, window / dt / kSubstepsRounded);
  std::size_t moving = 0;
  for (Proxy& p : state_.bodies) {
    const std::size_t k = p.body.is_static ? starts_.size() : moving++;
    double linear = 0.0, angular = 0.0;
    double pushed = p.impulse_sum, turned_by = p.moment_sum;  // what they are shares of [N s], [N m s]
    if (p.impulse_sum != 0.0) {
      linear = (p.linear_impulse + p.shell_linear).norm() / p.impulse_sum;
      angular = relative((p.angular_impulse + p.shell_angular).norm(), p.moment_sum);
    }
    if (k < starts_.size() && !p.is_driven() &&
        !(p.recovery > 0.0 && !state_.rows.empty())) {  // otherwise rows have moved it too
      const BodyMotion &then = starts_[k].motion, &now = p.body.motion;
      Vec3 gained = p.body.mass * (now.velocity - then.velocity - window * setup_.gravity);
      Vec3 turned = now.angular_momentum - then.angular_momentum;
      if (k < state_.kicks.size()) gained -= state_.kicks[k].linear, turned -= state_.kicks[k].angular;
      if (!p.unmoved) gained -= p.linear_impulse, turned -= p.angular_impulse;
      const double fall = window * setup_.gravity.norm(), scale = then.velocity.norm() + now.velocity.norm() + fall;
      const double turning = then.angular_momentum.norm() + now.angular_momentum.norm();
      const double in_velocity = relative(gained.norm(), p.impulse_sum + p.body.mass * scale) / roundings;
      const double in_spin = relative(turned.norm(), p.moment_sum + turning) / roundings;
      if (exceeds(in_velocity, linear)) linear = in_velocity, pushed += p.body.mass * scale;
      if (exceeds(in_spin, angular)) angular = in_spin, turned_by += turning;
    }
    ledger_linear_ = worse(linear, ledger_linear_), ledger_angular_ = worse(angular, ledger_angular_);
    if (!(linear <= kLedgerTolerance && angular <= kLedgerTolerance)) {  // NaN fails too
      Error e(Exit::kPhysics, "ledger",
              fmt::format("what the shell lost, body '{}' did not gain: {:.3g} linear of {:.3g} N s, {:.3g} angular of "
                          "{:.3g} N m s",
                          p.body.name, linear, pushed, angular, turned_by));
      e.window = clock_.windows, e.body = p.body.name;
      throw e;
    }
  }
}

void check_birth(BirthErrors& most, const RigidBody& b, const BirthErrors& found, double tolerance, const char* where,
                 const char* whose, std::int64_t window) {
  // The new value comes first: max() keeps its first argument when one is NaN.
  most.mass = std::max(found.mass, most.mass), most.momentum = std::max(found.momentum, most.momentum);
  most.angular_momentum = std::max(found.angular_momentum, most.angular_momentum);
  if (found.mass <= tolerance && found.momentum <= tolerance && found.angular_momentum <= tolerance)
    return;  // NaN is not
  Error e(Exit::kPhysics, "ledger",
          fmt::format("the birth of '{0}' {1}: {3:.3g} of {2} mass, {4:.3g} of {2} momentum and {5:.3g} of {2} "
                      "angular momentum are missing",
                      b.name, where, whose, found.mass, found.momentum, found.angular_momentum));
  e.window = window, e.body = b.name;
  throw e;
}

void Coupler::check_births(const std::vector<RigidBody>& births, const std::vector<link::State>& states) {
  const bool exact = rigid_->peer().can(link::capability::kDoublePrecision);
  for (const RigidBody& b : births)
    for (const link::State& s : states) {
      if (s.id != b.id || b.is_static) continue;
      const Vec3 momentum = b.mass * b.motion.velocity;
      const double scale = std::max(momentum.norm(), 1e-12), turn = std::max(b.motion.angular_momentum.norm(), 1e-12);
      const BirthErrors found{std::abs(s.mass - b.mass) / b.mass,
                              (s.mass * s.motion.velocity - momentum).norm() / scale,
                              (s.motion.angular_momentum - b.motion.angular_momentum).norm() / turn};
      check_birth(birth_errors_, b, found, exact ? kBirthTolerance : kSingleTolerance, "in the engine", "its",
                  clock_.windows);
    }
}

}  // namespace sunder::shell
