#include <cmath>

#include <gtest/gtest.h>

#include "shell/geometry/quadrature.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(GaussRule, IntegratesPolynomialsOfDegreeTwoNMinusOne) {
  for (int n = 1; n <= 16; ++n) {
    const GaussRule& g = gauss_rule(n);
    for (int power = 0; power <= 2 * n - 1; ++power) {
      double sum = 0.0;
      for (int i = 0; i < n; ++i) sum += g.weight[i] * std::pow(g.point[i], power);
      EXPECT_NEAR(sum, power % 2 ? 0.0 : 2.0 / (power + 1), 1e-14);
    }
  }
}
