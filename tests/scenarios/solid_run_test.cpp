// A block with a gap, among bodies and beside a sheet: an object in the gap is not touched.
#include <fstream>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/coupler/arch.h"
#include "tests/temporary_folder.h"
#include "tests/validation/coupled.h"

using namespace sunder;
using namespace sunder::validation;

namespace {

constexpr double kTop =
    (arch::kHigh * arch::kWide * arch::kHigh - arch::kGapHigh * (arch::kRight - arch::kLeft) * arch::kGapHigh) *
    arch::kDeep / (2.0 * arch::kVolume);  // height of its centre above its feet [m]

// `window` and `end` in seconds. Without a given sheet, the scene has a soft sheet that nothing touches.
std::string solid_scene(double end, double window, const std::string& gravity, const std::string& bodies,
                        const std::string& sheet = "") {
  return fmt::format(R"(name: "arch" end_time_s: {} window_s: {} gravity {{ {} }}
materials {{ name: "glass" density: 2500 youngs_modulus: 1e8 poisson_ratio: 0.2 }}
materials {{ name: "jelly" density: 2500 youngs_modulus: 1e6 poisson_ratio: 0.2 }}
{}
{}
)",
                     end, window, gravity,
                     sheet.empty() ? R"(shells { name: "sheet" material: "jelly" thickness_m: 0.002
  plate { size_x_m: 0.04 size_y_m: 0.04 elements_x: 4 elements_y: 4 pose { position { z: 3 } } }
  supports { edges: ALL kind: CLAMPED } })"
                                   : sheet,
                     bodies);
}

struct SolidEnd {
  std::string failure, summary;
  std::vector<RigidBody> bodies;
  double number(const std::string& section, const std::string& key) const {
    return nlohmann::json::parse(summary).at(section).at(key).get<double>();
  }
};

// The scene refers to the mesh arch.off beside it.
SolidEnd run_solid(const std::string& text, const std::string& engine) {
  SolidEnd e;
  WatchedRun end;
  e.failure = run_text(text, engine,
                       [&](double, double, const std::vector<const RigidBody*>& bodies) {
                         e.bodies.clear();
                         for (const RigidBody* b : bodies) e.bodies.push_back(*b);
                       },
                       &end, {}, {{"arch.off", arch::off(arch::mesh())}});
  e.summary = end.summary;
  return e;
}

std::string arch_at(double x, double y, double z, const std::string& more = "", const std::string& surface = "EXACT") {
  return fmt::format(R"(bodies {{ name: "arch" material: "glass" mesh {{ path: "arch.off" surface: {} }}
  pose {{ position {{ x: {} y: {} z: {} }} }} {} }})",
                     surface, x, y, z, more);
}

// Returns the angle of the body's z axis to the vertical, up to the order of principal axes: one face points down.
double tilt(const RigidBody& b) {
  double most = 0.0;
  for (int d = 0; d < 3; ++d) most = std::max(most, std::abs((b.motion.orientation * Vec3::Unit(d)).z()));
  return std::acos(std::min(1.0, most));
}

class Engines : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, Engines, testing::Values("bullet", "ode"),
                         [](const auto& i) { return std::string(i.param); });

TEST_P(Engines, ABallFliesThroughTheGapAndMeetsTheLeg) {
  const auto thrown = [&](double x, const std::string& surface) {
    return run_solid(
        solid_scene(0.05, 1e-3, "z: 0",
                    arch_at(0, 0, 0, "is_static: true", surface) +
                        fmt::format(R"( bodies {{ name: "ball" material: "glass" sphere {{ radius_m: 0.008 }}
  pose {{ position {{ x: {} y: -0.05 z: 0.015 }} }} twist {{ linear {{ y: 3 }} }} }})",
                                    x)),
        GetParam());
  };
  const SolidEnd through = thrown(0.03, "EXACT");
  ASSERT_EQ(through.failure, "");
  EXPECT_NEAR((through.bodies[1].motion.position - Vec3(0.03, 0.1, 0.015)).norm(), 0.0, 1e-12);  // 3 m/s for 50 ms
  EXPECT_NEAR(through.bodies[1].motion.velocity.y(), 3.0, 1e-12);
  EXPECT_LT(thrown(0.01, "EXACT").bodies[1].motion.velocity.y(), 0.1);  // the leg stops it, inelastically
  EXPECT_LT(thrown(0.03, "HULL").bodies[1].motion.velocity.y(), 0.1);   // the hull stops it too
}

TEST_P(Engines, StandsOnTheFloorOnTwoFeetOverABall) {
  const SolidEnd e = run_solid(
      solid_scene(0.2, 1e-3, "z: -9.81",
                  R"(bodies { name: "floor" half_space {} } )" + arch_at(0, 0, 0.002) + R"( bodies { name: "ball"
  material: "glass" sphere { radius_m: 0.008 } pose { position { x: 0.03 y: 0.015 z: 0.008 } } })"),
      GetParam());
  ASSERT_EQ(e.failure, "");
  EXPECT_NEAR(e.bodies[1].motion.position.z(), kTop, 1e-4);  // as every engine holds a body on a floor
  EXPECT_LT(tilt(e.bodies[1]), 1e-3);
  EXPECT_NEAR((e.bodies[2].motion.position - Vec3(0.03, 0.015, 0.008)).norm(), 0.0, 1e-4);
}

TEST(SolidOnASheet, StandsOnTwoFeet) {
  const double half = 0.002;
  const SolidEnd e = run_solid(solid_scene(0.06, 1e-4, "z: -9.81", arch_at(-0.03, -0.015, half + 0.0005),
                                           R"(shells { name: "sheet" material: "glass" thickness_m: 0.004
  plate { size_x_m: 0.15 size_y_m: 0.15 elements_x: 16 elements_y: 16 } supports { edges: ALL kind: CLAMPED } })"),
                               "bullet");
  ASSERT_EQ(e.failure, "");
  const RigidBody& b = e.bodies[0];
  const double weight = b.mass * 9.81;
  // The static deflection of a clamped plate under a weight in its middle, w = 0.0056 F a^2 / D (Timoshenko), is the
  // least; it also swings.
  const double bent = 0.0056 * weight * 0.15 * 0.15 / (1e8 * std::pow(0.004, 3) / 12.0 / (1.0 - 0.04));
  EXPECT_GT(b.motion.position.z(), half + kTop - 2.5 * bent);
  EXPECT_LT(b.motion.position.z(), half + kTop + 5e-4);
  EXPECT_LT(tilt(b), 5e-3);
  EXPECT_LT(e.number("ledger", "linear_max"), 1e-12);
  EXPECT_LT(e.number("ledger", "angular_max"), 1e-12);
  EXPECT_LT(std::abs(e.number("energy", "residual_relative")), 1e-3);
  EXPECT_GT(e.number("energy", "contact"), 0.0);
}

TEST(SolidOnASheet, LeavesASheetInItsGapAloneUntilItMeetsTheWall) {
  // The sheet stands in the gap with its edge inside: z is its u, and it moves along x.
  const auto beside = [](double velocity, const std::string& surface) {
    return run_solid(solid_scene(0.01, 1e-4, "z: 0", arch_at(-0.03, -0.015, -0.005, "is_static: true", surface),
                                 fmt::format(R"(shells {{ name: "sheet" material: "glass" thickness_m: 0.002
  plate {{ size_x_m: 0.08 size_y_m: 0.02 elements_x: 16 elements_y: 4
    pose {{ position {{ z: -0.02 }} orientation {{ w: 0.7071067811865476 y: 0.7071067811865476 }} }} }}
  velocity {{ x: {} }} }})",
                                             velocity)),
                     "bullet");
  };
  const SolidEnd still = beside(0.5, "EXACT");  // ends half way to the wall, 9 mm from it
  ASSERT_EQ(still.failure, "");
  EXPECT_EQ(still.number("energy", "contact"), 0.0);
  EXPECT_NE(beside(0.5, "HULL").failure.find("inside shell 'sheet'"), std::string::npos);
  const SolidEnd met = beside(1.5, "EXACT");  // would reach 6 mm into the wall
  ASSERT_EQ(met.failure, "");
  EXPECT_GT(met.number("energy", "contact"), 0.0);
  EXPECT_LT(met.number("ledger", "linear_max"), 1e-12);
  EXPECT_LT(std::abs(met.number("energy", "residual_relative")), 1e-3);
}

}  // namespace
