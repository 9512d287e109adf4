#include <cmath>

#include <gtest/gtest.h>

#include "shell/solver/cracking/crack_rules.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(TipRules, TakeMoreSurfaceStressInBendingThanInStretching) {
  const ShellModel m = brittle_sheet();
  const CrackRules r = make_crack_rules(m, 0.0075);
  const double toughness = std::sqrt(70e9 * 8 / 0.0075);
  EXPECT_NEAR(r.tip_strength, 0.6913 * toughness, 0.001 * toughness);
  // fields of Irwin and of Williams with nu = 0.22, integrated apart (the latter from differences of the deflection)
  EXPECT_NEAR(r.tip_bending_strength, 1.5551 * toughness, 0.001 * toughness);
}
