// The ledger of a window, and the check of births.
#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/run/coupler.h"
#include "tests/shell/rig.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kWindow = 1e-3;  // [s]

/// A window of a body that no shell solves: the test pushes it itself.
struct Window {
  explicit Window(const std::function<void(Proxy&)>& push)
      : rig(setup()), coupler(rig.setup(), rig.simulation(), clock, {}) {
    clock.windows = 7;
    coupler.open_window(kWindow);
    Proxy& p = rig.body();
    p.body.motion.velocity += kWindow * rig.setup().gravity;
    push(p);
  }
  static RunSetup setup() {
    RunSetup s;
    s.gravity = Vec3(0, 0, -9.81);
    RigidBody b;
    b.id = 1, b.name = "ball", b.mass = 0.3, b.principal_inertia = Vec3(1e-4, 2e-4, 3e-4), b.shape = SphereShape{0.02};
    b.motion.velocity = Vec3(1, 2, -3), b.motion.angular_momentum = Vec3(1e-4, 0, 2e-4);
    s.bodies = {b};
    return s;
  }
  /// The refusal, or an empty text.
  std::string refusal() {
    try {
      coupler.check_ledger(kWindow, kWindow);
    } catch (const Error& e) {
      EXPECT_EQ(e.kind, "ledger");
      EXPECT_EQ(e.status, Exit::kPhysics);
      EXPECT_EQ(e.window, 7);
      EXPECT_EQ(e.body, "ball");
      return e.what();
    }
    return "";
  }
  Clock clock;
  Rig rig;
  Coupler coupler;
};

/// An impulse on the shell at an arm from the body's centre, on both pages.
void push(Proxy& p) {
  const Vec3 j(0.02, -0.01, -0.4), arm(0.003, 0.001, -0.019);
  p.apply(p.body.motion.position + arm, -j);
  p.shell_linear += j, p.shell_angular += arm.cross(j);
  p.impulse_sum += j.norm(), p.moment_sum += arm.norm() * j.norm();
}

}  // namespace

TEST(Ledger, ClosesWhereTheBodyGainsWhatTheShellLost) {
  Window fallen([](Proxy&) {}), pushed(push);
  EXPECT_EQ(fallen.refusal(), "");
  EXPECT_EQ(pushed.refusal(), "");
  EXPECT_LT(pushed.coupler.ledger_linear(), 1e-14);  // round-off of a few sums
  EXPECT_LT(pushed.coupler.ledger_angular(), 1e-14);
}

TEST(Ledger, StopsTheRunWhereEitherPageIsWrong) {
  const double off = 1e-11;  // ten times the tolerance
  const auto with = [&](const std::function<void(Proxy&)>& spoil) {
    return Window([&](Proxy& p) { push(p), spoil(p); }).refusal();
  };
  const Vec3 x = Vec3::UnitX();
  EXPECT_NE(with([&](Proxy& p) { p.shell_linear += off * p.impulse_sum * x; }), "");
  EXPECT_NE(with([&](Proxy& p) { p.shell_angular += off * p.moment_sum * x; }), "");
  // the pages agree, but the body moves otherwise
  EXPECT_NE(with([&](Proxy& p) { p.body.motion.velocity += 1e-9 * x; }), "");
  EXPECT_NE(with([&](Proxy& p) { p.body.motion.angular_momentum += 1e-12 * x; }), "");
  EXPECT_NE(with([&](Proxy& p) { p.shell_linear.x() = std::numeric_limits<double>::quiet_NaN(); }), "");
  EXPECT_NE(with([&](Proxy& p) { p.body.motion.velocity.z() = std::numeric_limits<double>::quiet_NaN(); }), "");
}

TEST(Ledger, NamesBodyAndNumbers) {
  const std::string said = Window([](Proxy& p) { push(p), p.shell_linear *= 1.5; }).refusal();
  EXPECT_NE(said.find("'ball'"), std::string::npos) << said;
  EXPECT_NE(said.find("0.5 linear"), std::string::npos) << said;
  // of the momentum before and after, where nothing touched the body: 0.3 kg, from 3.742 m/s to 3.755 m/s, and its fall
  const std::string alone = Window([](Proxy& p) { p.body.motion.velocity.x() += 0.01; }).refusal();
  EXPECT_NE(alone.find("linear of 2.25 N s"), std::string::npos) << alone;
}

TEST(Birth, KeepsTheLargestErrorsAndRefusesLargerOnesThanTheTolerance) {
  RigidBody b;
  b.name = "shard_4";
  BirthErrors most;
  check_birth(most, b, {1e-12, 3e-11, 0.0}, kBirthTolerance, "here", "its", 3);
  check_birth(most, b, {2e-12, 1e-11, 5e-11}, kBirthTolerance, "here", "its", 3);
  EXPECT_EQ(most.mass, 2e-12);
  EXPECT_EQ(most.momentum, 3e-11);
  EXPECT_EQ(most.angular_momentum, 5e-11);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const BirthErrors& wrong : {BirthErrors{2e-10, 0, 0}, {0, 2e-10, 0}, {0, 0, 2e-10}, {nan, 0, 0}, {0, 0, nan}}) {
    BirthErrors none;
    EXPECT_THROW(check_birth(none, b, wrong, kBirthTolerance, "here", "its", 3), Error);
  }
}
