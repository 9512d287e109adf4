// Joints that break: the time of release, and the motion after it.
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/validation/coupled.h"

using namespace sunder;
using namespace sunder::validation;

namespace {

constexpr double kWindow = 1e-3, kGravity = 9.81;

// A rod of 0.3 m along x from the world's origin, and a sheet that nothing touches.
std::string scene_text(const std::string& scheme, const std::string& joint, const std::string& gravity = "z: -9.81") {
  return fmt::format(R"(name: "rod" end_time_s: 0.3 window_s: {} gravity {{ {} }} coupling {{ scheme: {} }}
materials {{ name: "jelly" density: 2500 youngs_modulus: 1e6 poisson_ratio: 0.2 }}
shells {{ name: "sheet" material: "jelly" thickness_m: 0.002
  plate {{ size_x_m: 0.04 size_y_m: 0.04 elements_x: 4 elements_y: 4 pose {{ position {{ z: 9 }} }} }}
  supports {{ edges: ALL kind: CLAMPED }} }}
bodies {{ name: "rod" material: "jelly" box {{ size_m {{ x: 0.3 y: 0.02 z: 0.02 }} }} pose {{ position {{ x: 0.15 }} }} }}
joints {{ name: "pin" first: "rod" position {{ }} {} }}
)",
                     kWindow, gravity, scheme, joint);
}

struct Moment {
  double time;
  BodyMotion motion;
};

struct Ended {
  std::string failure;
  std::vector<Moment> moments;
  double released = -1.0;  // [s]; negative: the joint holds
};

Ended run(const std::string& text, const std::string& engine) {
  Ended e;
  WatchedRun end;
  e.failure = run_text(
      text, engine,
      [&](double time, double, const std::vector<const RigidBody*>& bodies) {
        e.moments.push_back({time, bodies[0]->motion});
      },
      &end);
  const nlohmann::json released = nlohmann::json::parse(end.summary).at("joints").at(0).at("released_s");
  if (!released.is_null()) e.released = released.get<double>();
  return e;
}

double turned(const BodyMotion& m) { return 2.0 * std::atan2(m.orientation.vec().norm(), std::abs(m.orientation.w())); }

// From just after the release to the end the rod follows a parabola and keeps its spin.
void expect_free_flight(const Ended& e, const Vec3& gravity) {
  ASSERT_GT(e.released, 0.0);
  const Moment *first = nullptr, &last = e.moments.back();
  for (const Moment& m : e.moments)
    if (!first && m.time > e.released - 0.5 * kWindow) first = &m;
  ASSERT_TRUE(first);
  const double t = last.time - first->time;
  ASSERT_GT(t, 0.05);
  // Free fall is exact at any substep; round-off of some 200 windows remains.
  const Vec3 path = first->motion.position + t * first->motion.velocity + 0.5 * t * t * gravity;
  EXPECT_LT((last.motion.position - path).norm(), 1e-10);
  EXPECT_LT((last.motion.velocity - first->motion.velocity - t * gravity).norm(), 1e-10);
  EXPECT_LT((last.motion.angular_momentum - first->motion.angular_momentum).norm(), 1e-12);
}

struct Way {
  const char *engine, *scheme;
};

class Breaking : public testing::TestWithParam<Way> {};
INSTANTIATE_TEST_SUITE_P(All, Breaking,
                         testing::Values(Way{"bullet", "PROXY"}, Way{"bullet", "EXPORTED"}, Way{"bullet", "ITERATED"},
                                         Way{"ode", "PROXY"}, Way{"ode", "EXPORTED"}),
                         [](const auto& i) { return std::string(i.param.engine) + "_" + i.param.scheme; });

TEST_P(Breaking, AHingeIsReleasedInTheFirstWindowPastItsAngle) {
  const double angle = 40.0 * M_PI / 180.0;
  const Ended e =
      run(scene_text(GetParam().scheme, "kind: HINGE axis { y: 1 } breaks { angle_deg: 40 }"), GetParam().engine);
  ASSERT_EQ(e.failure, "");
  ASSERT_GT(e.released, 0.0);
  for (const Moment& m : e.moments) {
    if (m.time < e.released - 0.5 * kWindow) {
      EXPECT_LT(turned(m.motion), angle);
    } else if (m.time < e.released + 0.5 * kWindow) {
      EXPECT_GE(turned(m.motion), angle);
      // The rod swings from rest about its end: I w^2 / 2 = m g h. The scheme is of first order in a window.
      const double inertia = 0.3 * 0.3 / 3.0 + 0.02 * 0.02 / 12.0;  // per mass
      const double spin = std::sqrt(2.0 * kGravity * 0.15 * std::sin(turned(m.motion)) / inertia);
      EXPECT_NEAR(m.motion.velocity.norm() / 0.15, spin, 0.02 * spin);
    }
  }
  expect_free_flight(e, {0, 0, -kGravity});
}

TEST_P(Breaking, ASliderIsReleasedPastItsExtensionAndABallAtItsTime) {
  const Ended slid =
      run(scene_text(GetParam().scheme, "kind: SLIDER axis { x: 1 } breaks { extension_m: 0.05 time_s: 0.25 }",
                     "x: 5 z: -9.81"),
          GetParam().engine);
  ASSERT_EQ(slid.failure, "");
  EXPECT_NEAR(slid.released, std::ceil(std::sqrt(2.0 * 0.05 / 5.0) / kWindow) * kWindow, 1.5 * kWindow);
  expect_free_flight(slid, {5, 0, -kGravity});
  const Ended timed =
      run(scene_text(GetParam().scheme, "kind: BALL breaks { time_s: 0.0105 angle_deg: 90 }"), GetParam().engine);
  ASSERT_EQ(timed.failure, "");
  EXPECT_NEAR(timed.released, 0.011, 1e-12);
  expect_free_flight(timed, {0, 0, -kGravity});
}

TEST(Holding, AHingeHoldsBelowItsAngle) {
  const Ended e = run(scene_text("PROXY", "kind: HINGE axis { y: 1 } breaks { angle_deg: 179 }"), "bullet");
  ASSERT_EQ(e.failure, "");
  EXPECT_LT(e.released, 0.0);
  EXPECT_NEAR(e.moments.back().motion.position.norm(), 0.15, 1e-4);
}

}  // namespace
