// Bodies that follow a prescribed motion, with every engine: work, energy, other bodies, and shapes that change.
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/coupler/arch.h"
#include "tests/validation/coupled.h"

using namespace sunder;
using namespace sunder::validation;

namespace {

/// A number of a section of run.json.
double number(const std::string& json, const std::string& section, const std::string& key) {
  return nlohmann::json::parse(json).at(section).at(key).get<double>();
}

const std::string kSheet = R"(name: "driven" end_time_s: 0.02 window_s: 2e-4 gravity {}
materials { name: "soft" density: 1000 youngs_modulus: 1e8 poisson_ratio: 0.3 }
shells { name: "pane" material: "soft" thickness_m: 0.002
  plate { size_x_m: 0.2 size_y_m: 0.2 elements_x: 16 elements_y: 16 } supports { edges: ALL kind: CLAMPED } }
)";

class Driven : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, Driven, testing::Values("bullet", "ode", "freeflight"));

TEST_P(Driven, BallFollowsItsKeysAndItsWorkIsInTheBooks) {
  WatchedRun end;
  double deepest = 1.0, last = 0.0, off = 0.0;
  const std::string failure = run_text(
      kSheet + R"(bodies { name: "ball" sphere { radius_m: 0.03 }
  motion { position { z: 0.0312 } } motion { time_s: 0.01 position { z: 0.0212 } rotation { angle_deg: 90 } }
  motion { time_s: 0.02 position { z: 0.0312 } } })",
      GetParam(),
      [&](double time, double, const std::vector<const RigidBody*>& bodies) {
        const double z = bodies[0]->motion.position.z(), s = time / 0.01;
        deepest = std::min(deepest, z), last = z;
        if (s < 1.0) off = std::max(off, std::abs(z - 0.0312 + 0.01 * s * s * (3.0 - 2.0 * s)));
      },
      &end);
  ASSERT_EQ(failure, "");
  EXPECT_LT(off, 1e-15);
  EXPECT_NEAR(deepest, 0.0212, 1e-15);
  EXPECT_NEAR(last, 0.0312, 1e-15);
  // The sheet resists on the way down and gives less on the way up, as it vibrates and has rubbed on the ball.
  EXPECT_GT(number(end.summary, "energy", "external_work"), 1e-3);
  // The books close to the square of a substep over the shortest period.
  EXPECT_LT(std::abs(number(end.summary, "energy", "residual_relative")), 1e-4);
  EXPECT_LT(number(end.summary, "ledger", "linear_max"), 1e-13);
}

TEST_P(Driven, HammerTakesAFreeBoxAlongWhereTheEngineHasContact) {
  WatchedRun end;
  Vec3 speed = Vec3::Zero();
  const std::string failure = run_text(
      kSheet + R"(bodies { name: "free" material: "soft" box { size_m { x: 0.02 y: 0.02 z: 0.02 } }
  pose { position { x: 0.2 z: 0.5 } } }
bodies { name: "hammer" box { size_m { x: 0.1 y: 0.05 z: 0.05 } }
  motion { position { z: 0.5 } twist { linear { x: 10 } } } motion { time_s: 0.02 position { x: 0.2 z: 0.5 } twist { linear { x: 10 } } } })",
      GetParam(), [&](double, double, const std::vector<const RigidBody*>& b) { speed = b[0]->motion.velocity; }, &end);
  ASSERT_EQ(failure, "");
  const double mass = 1000 * 0.02 * 0.02 * 0.02, energy = 0.5 * mass * 100.0;
  if (std::string(GetParam()) == "freeflight") {
    EXPECT_EQ(speed.x(), 0.0);
    return;
  }
  // Engines see the hammer as 1e4 times as heavy as everything else.
  EXPECT_NEAR(speed.x(), 10.0, 2e-3);
  // m v^2 of work: half of it moves the box, half is lost in the impact.
  EXPECT_NEAR(number(end.summary, "energy", "external_work"), 2.0 * energy, 2e-3 * energy);
  EXPECT_NEAR(number(end.summary, "energy", "engine"), energy, 2e-3 * energy);
  EXPECT_LT(std::abs(number(end.summary, "energy", "residual_relative")), 1e-6);
}

TEST(Driven, BodyHoldsAJointThatSwings) {
  double most = 0.0;
  Vec3 at = Vec3::Zero(), held = Vec3::Zero();
  const std::string failure =
      run_text(kSheet + R"(bodies { name: "bob" material: "soft" box { size_m { x: 0.02 y: 0.02 z: 0.02 } }
  pose { position { z: 0.4 } } }
bodies { name: "hand" box { size_m { x: 0.02 y: 0.02 z: 0.02 } }
  motion { position { z: 0.5 } } motion { time_s: 0.02 position { x: 0.02 z: 0.5 } } }
joints { name: "string" kind: BALL first: "bob" second: "hand" position { z: 0.5 } })",
               "bullet", [&](double, double, const std::vector<const RigidBody*>& b) {
                 at = b[0]->motion.position, held = b[1]->motion.position;
                 const Vec3 end = at + b[0]->motion.orientation * Vec3(0, 0, 0.1);
                 most = std::max(most, (end - held).norm());
               });
  ASSERT_EQ(failure, "");
  EXPECT_NEAR(held.x(), 0.02, 1e-15);
  EXPECT_LT(most, 1e-4) << "the joint is off its place by what a window leaves";
  EXPECT_LT(at.x(), 0.02) << "the bob lags behind the hand";
}

TEST(Driven, BodyOnWhatDoesNotGiveWayBooksWhatFreeBodiesGain) {
  const std::string floor = "bodies { name: \"floor\" half_space {} pose { position { z: -0.1 } } }";
  const std::string free =
      "bodies { name: \"free\" material: \"soft\" box { size_m { x: 0.02 y: 0.02 z: 0.02 } } pose { position { x: 0.3 "
      "z: -0.089 } } }";
  const std::string press =
      "bodies { name: \"press\" box { size_m { x: 0.1 y: 0.05 z: 0.02 } } motion { position { x: 0.3 z: -0.068 } } "
      "motion { time_s: 0.01 position { x: 0.3 z: -0.091 } } }";
  for (const char* engine : {"bullet", "ode"})
    for (const std::string& bodies : {floor + press, floor + free + press}) {
      WatchedRun end;
      ASSERT_EQ(run_text(
                    kSheet + bodies, engine, [](double, double, const std::vector<const RigidBody*>&) {}, &end),
                "");
      // A box of 8 g that leaves at ten times the top speed of the press, 3.45 m/s, has 4.8 J.
      EXPECT_LT(std::abs(number(end.summary, "energy", "external_work")), bodies == floor + press ? 1e-12 : 4.8)
          << engine;
      EXPECT_NE(end.summary.find("'press', which follows a prescribed motion, pressed on"), std::string::npos)
          << engine;
      EXPECT_LT(std::abs(number(end.summary, "energy", "residual_relative")), 1e-3) << engine;
    }
}

TEST(Driven, BodyOnAFrozenSheetDoesNoFurtherWork) {
  const std::string frozen =
      "fracture { mode: CUTS latest_freeze_s: 2e-3 } bodies { name: \"punch\" sphere { radius_m: 0.03 } "
      "motion { position { x: 0.05 z: 0.0315 } } motion { time_s: 1e-2 position { x: 0.05 z: 0.019 } } }";
  std::string scene = kSheet;
  const std::string held = "supports { edges: ALL kind: CLAMPED }";
  scene.replace(scene.find(held), held.size(), held + " cuts { points { u: 0.16 v: 0 } points { u: 0.16 v: 0.2 } }");
  WatchedRun end, early;
  const auto none = [](double, double, const std::vector<const RigidBody*>&) {};
  ASSERT_EQ(run_text(scene + frozen, "bullet", none, &end), "");
  scene.replace(scene.find("end_time_s: 0.02"), 16, "end_time_s: 2e-3");
  ASSERT_EQ(run_text(scene + frozen, "bullet", none, &early), "");
  EXPECT_GT(number(early.summary, "energy", "external_work"), 0.0);
  EXPECT_NEAR(number(end.summary, "energy", "external_work"), number(early.summary, "energy", "external_work"), 1e-6);
}

// The arch below a clamped sheet grows into it, by normals or by a mesh of its own.
std::string grown(const std::string& deformation) {
  return kSheet +
         "bodies { name: \"arch\" mesh { path: \"arch.off\" surface: EXACT } pose { position { x: -0.03 y: -0.015 "
         "z: -0.052 } } deformation { " +
         deformation + " } }";
}

TEST(Deforming, SurfacePressesTheSheetAndItsWorkIsBooked) {
  arch::Mesh larger = arch::mesh();
  for (Vec3& p : larger.points) p = Vec3(0.03, 0.015, 0) + 1.2 * (p - Vec3(0.03, 0.015, 0));
  const std::map<std::string, std::string> files{{"arch.off", arch::off(arch::mesh())},
                                                 {"larger.off", arch::off(larger)},
                                                 {"grows.pc2", arch::pc2({arch::mesh().points, larger.points}, 0, 1)}};
  for (const char* how :
       {"inflate { } inflate { time_s: 0.02 distance_m: 0.008 }", "shapes { time_s: 0.02 path: \"larger.off\" }",
        "cache { path: \"grows.pc2\" frames_per_second: 50 }"}) {
    WatchedRun end;
    const std::string failure = run_text(
        grown(how), "bullet", [](double, double, const std::vector<const RigidBody*>&) {}, &end, {}, files);
    ASSERT_EQ(failure, "") << how;
    const double work = number(end.summary, "energy", "external_work");
    EXPECT_GT(work, 1e-4) << how;
    EXPECT_GT(number(end.summary, "energy", "elastic"), 0.5 * work) << how;
    EXPECT_LT(std::abs(number(end.summary, "energy", "residual_relative")), 5e-4)
        << how;  // corners press harder than a ball
  }
}

}  // namespace
