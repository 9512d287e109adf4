// Seams that open at a force.
#include "shell/solver/joining/seam_strength.h"

#include <gtest/gtest.h>

#include "tests/shell/fixtures.h"
#include "tests/shell/stitched.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kSeamStrength = 1e5;  // [N/m]
constexpr double kRise = 4e-3;         // of the load: a dozen periods of the slowest stretching

/// Two halves of a strip along x, the left one clamped; its right end is pulled with a force a length that rises.
RunSetup pulled(const Vec3& pull, Join join, int right_rows, double strength) {
  Support clamp;
  clamp.edges = kUMin;
  Load load;
  load.kind = Load::Kind::kEdgeForce, load.edges = kUMax, load.force = pull;
  load.in_time = {{0.0, 0.0}, {kRise, 1.0}};
  ShellMaterial m = glass();
  m.mass_damping = 2e3;
  RunSetup out =
      Stitched::joined({make_shell("left", flat(0, 0.2, 0, 0.1, 8, 4), 0.004, m, 2, 2, {clamp}),
                        make_shell("right", flat(0.2, 0.4, 0, 0.1, 8, right_rows), 0.004, m, 2, 2, {}, {load})},
                       join, 1e-6);
  for (Seam& seam : out.stitches.seams) seam.strength = strength;
  return out;
}

/// Force a length at which the seam opens, as a share of its strength; 0: it holds.
double opens_at(double pull, Join join, int right_rows) {
  Rig rig(pulled(Vec3(pull, 0, 0), join, right_rows, kSeamStrength));
  constexpr double kStep = 1e-6;
  double at = 0.0;
  rig.simulation().state.shells[0].state->motion.time = 0.0;
  rig.run(static_cast<int>(1.2 * kRise / kStep), kStep, [&] {
    const double time = rig.state(1).motion.time;
    if (at == 0.0 && rig.now().stitching.parted()) at = pull / kSeamStrength * std::min(1.0, time / kRise);
  });
  return at;
}

}  // namespace

// The load rises slowly, so the force at the seam is the load, but for the motion that is left.
TEST(SeamStrength, OpensAtItsForce) {
  for (const Join join : {Join::kClamped, Join::kHinge})
    for (const int rows : {4, 8, 6}) {
      SCOPED_TRACE(rows);
      EXPECT_EQ(opens_at(0.95 * kSeamStrength, join, rows), 0.0);
      EXPECT_NEAR(opens_at(1.5 * kSeamStrength, join, rows), 1.0, 0.05);
    }
}

TEST(SeamStrength, ASeamThatHasOpenedLetsTheShellsGo) {
  Rig rig(pulled(Vec3(3 * kSeamStrength, 0, 0), Join::kClamped, 4, kSeamStrength));
  rig.run(2000, 2e-6);
  int links = 0;
  rig.now().stitching.each_link([&](int, int, int, int) { ++links; });
  EXPECT_EQ(links, 0);
  const ShellModel& right = rig.model(1);
  EXPECT_GT(rig.state(1).position(right.tables.slot(0)).x(), 0.2 + 1e-3);  // its edge at the seam has left
  const ShellModel& left = rig.model(0);
  EXPECT_LT(rig.state(0).position(left.tables.slot(left.patch.columns() - 1)).x(), 0.2 + 1e-4);
}

TEST(SeamStrength, IsAskedForBySeam) {
  Rig with(pulled(Vec3(1, 0, 0), Join::kClamped, 4, kSeamStrength)),
      without(pulled(Vec3(1, 0, 0), Join::kClamped, 4, 0.0));
  EXPECT_FALSE(with.now().seam_strength.empty());
  EXPECT_TRUE(without.now().seam_strength.empty());
}
