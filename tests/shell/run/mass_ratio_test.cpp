// Heavy bodies on light ones: which pairs are told.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "shell/run/mass_ratio.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kSide = 0.2;  // [m]
const Vec3 kGravity(0, 0, -9.81);

Proxy cube(BodyId id, const char* name, double mass, double z) {
  RigidBody b;
  b.id = id, b.name = name, b.mass = mass, b.principal_inertia = Vec3::Constant(mass * kSide * kSide / 6.0);
  b.shape = BoxShape{Vec3::Constant(0.5 * kSide)};
  b.motion.position = {0, 0, z};
  return Proxy(b);
}

std::vector<Proxy> stack(double ratio) { return {cube(7, "lower", 1.0, 0.1), cube(9, "upper", ratio, 0.3)}; }

std::string told(const std::vector<Proxy>& bodies, double window, int looks = 5, const Vec3& gravity = kGravity,
                 bool double_precision = true) {
  HeavyPair pair;
  for (int k = 0; k < looks; ++k) look_for_heavy(bodies, bodies.size(), gravity, window, double_precision, pair);
  return heavy_warning(bodies, pair, "bullet");
}

}  // namespace

TEST(HeavyPair, IsToldWithBothNamesTheRatioAndAWindowThatIsNotTold) {
  const std::string said = told(stack(1000.0), 2e-3);
  EXPECT_NE(said.find("'upper' lies on 'lower', which is 1e+03 times lighter"), std::string::npos) << said;
  EXPECT_NE(said.find("'bullet'"), std::string::npos) << said;
  const std::size_t at = said.find("a window_s of ");
  ASSERT_NE(at, std::string::npos) << said;
  const double window = std::stod(said.substr(at + 14));
  EXPECT_GT(window, 2e-4);
  EXPECT_EQ(told(stack(1000.0), window), "");
  EXPECT_NE(told(stack(1000.0), 1.04 * window), "");  // rounded down to two digits, of 3.1
}

// The scene that slid: windows of 3.125e-4 s, which double precision holds.
TEST(HeavyPair, IsToldSoonerInSinglePrecision) {
  EXPECT_EQ(told(stack(1000.0), 3.125e-4), "");
  const std::string said = told(stack(1000.0), 3.125e-4, 5, kGravity, false);
  EXPECT_NE(said.find("a window_s of 0.0001 s or less"), std::string::npos) << said;
  EXPECT_EQ(told(stack(1000.0), 1e-4, 5, kGravity, false), "");
}

TEST(HeavyPair, LongerWindowsHoldSmallerRatios) {
  EXPECT_EQ(told(stack(50.0), 1e-3), "");
  EXPECT_NE(told(stack(200.0), 1e-2), "");
  EXPECT_EQ(told(stack(15.0), 0.1), "");  // every engine holds it
}

TEST(HeavyPair, IsNotedOnlyWhereOneLiesOnTheOther) {
  std::vector<Proxy> bodies = stack(1000.0);
  EXPECT_NE(told(bodies, 2e-3), "");
  EXPECT_EQ(told(bodies, 2e-3, 2), "");                    // a body that bounces off
  EXPECT_EQ(told(bodies, 2e-3, 5, Vec3::Zero()), "");      // no weight
  EXPECT_EQ(told(bodies, 2e-3, 5, Vec3(0, 0, 9.81)), "");  // the light one lies on the heavy one
  bodies[1].body.motion.position.z() += 0.1 * kSide;
  EXPECT_EQ(told(bodies, 2e-3), "");  // above it
  bodies = stack(1000.0), bodies[1].body.motion.velocity = {0, 0, -3.0};
  EXPECT_EQ(told(bodies, 2e-3), "");  // passing
  bodies = stack(1000.0), bodies[0].body.is_static = true;
  EXPECT_EQ(told(bodies, 2e-3), "");
}
