// The law of a damaged layer, point by point.
#include <cmath>

#include <gtest/gtest.h>

#include "shell/mechanics/layers_weakening.h"
#include "shell/mechanics/pack.h"

using namespace sunder::shell;

TEST(Brittleness, IsThatOfEquationNineAndNoneWhereTheGridDoesNotResolveTheSoftening) {
  // Hbar l = strength^2 l / (2 E G_f)
  EXPECT_NEAR(brittleness(2e6, 3e9, 12.0, 0.006), 1.0 / 2.0, 1e-14);  // Hbar l = 1/3
  EXPECT_EQ(brittleness(2e6, 3e9, 12.0, 0.0181), -1.0);               // just above 1
  EXPECT_EQ(brittleness(2e6, 3e9, 12.0, 1.0), -1.0);
}

// One axis pulled at unit metric and volume: c = (1 + H) (1 - strength / stress), and stress falls linearly.
TEST(Weaken, FollowsTheCurveOfOneAxis) {
  const double strength = 2.0, h = 0.5;
  for (const double pull : {1.0, 2.0, 2.5, 4.0, 6.0, 9.0}) {
    Sym2<double> s{pull, 0.0, 0.0};
    const double damage = weaken<double>(s, {1.0, 1.0, 0.0}, 1.0, strength, h);
    const double exact = pull <= strength ? 0.0 : std::min(1.0, (1.0 + h) * (1.0 - strength / pull));
    EXPECT_NEAR(damage, exact, 1e-15 * 4) << pull;
    EXPECT_NEAR(s.c11, (1.0 - exact) * pull, 1e-14) << pull;
    EXPECT_NEAR(s.c22, 0.0, 1e-14) << pull;
  }
}

TEST(Weaken, LeavesCompressionAloneAndKeepsItsMaximumWhereItDoesNotHeal) {
  Sym2<double> pressed{9.0, -5.0, 0.0};
  EXPECT_EQ(weaken<double>(pressed, {1.0, 1.0, 0.0}, 1.0, 2.0, 0.5), 1.0);
  EXPECT_NEAR(pressed.c11, 0.0, 1e-13);
  EXPECT_NEAR(pressed.c22, -5.0, 1e-13);
  Sym2<double> released{1.0, 0.0, 0.0}, healed = released;
  EXPECT_EQ((weaken<double, false>(released, {1.0, 1.0, 0.0}, 1.0, 2.0, 0.5, 0.4)), 0.4);
  EXPECT_NEAR(released.c11, 0.6, 1e-15);
  EXPECT_EQ((weaken<double, true>(healed, {1.0, 1.0, 0.0}, 1.0, 2.0, 0.5, 0.4)), 0.0);
  EXPECT_EQ(healed.c11, 1.0);
}
