// Speed of a tip and the fracture energy at it.
#include "shell/solver/cracking/tip_speed.h"

#include <gtest/gtest.h>

#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(TipSpeed, IsFreundsWhereTheFractureEnergyIsConstant) {
  const ShellMaterial m = glass();
  EXPECT_EQ(tip_speed(m, 0.5), 0.0);
  EXPECT_EQ(tip_speed(m, 1.0), 0.0);
  EXPECT_DOUBLE_EQ(tip_speed(m, 4.0), 0.75);
  EXPECT_EQ(toughened(m, 0.9), 1.0);
}

TEST(TipSpeed, BalancesEnergyAtEverySpeed) {
  ShellMaterial m = glass();
  m.crack_speed_onset = 0.44, m.toughening = 97.5;
  double last = 0.0;
  for (double g = 1.01; g < 1e4; g *= 1.1) {
    const double speed = tip_speed(m, g);
    EXPECT_NEAR((1.0 - speed) * g, toughened(m, speed), 1e-9 * g) << g;
    EXPECT_GT(speed, last) << g;
    EXPECT_LT(speed, 1.0);
    last = speed;
  }
  EXPECT_NEAR(tip_speed(m, 13.7), 0.5, 1e-3);  // glass divides at half the Rayleigh speed
  EXPECT_NEAR(toughened(m, 0.5), 6.85, 1e-2);
}

TEST(TipSpeed, DoesNotJumpAtTheOnset) {
  ShellMaterial m = glass();
  m.crack_speed_onset = 0.36, m.toughening = 20.7;
  const double g = 1.0 / (1.0 - 0.36);
  EXPECT_NEAR(tip_speed(m, g * (1.0 - 1e-9)), 0.36, 1e-8);
  EXPECT_NEAR(tip_speed(m, g * (1.0 + 1e-9)), 0.36, 1e-8);
}
