#include <cmath>

#include <gtest/gtest.h>

#include "shell/grid/kernel.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(GridWeights, SumToOneAndReproduceThePlace) {
  for (const double x : {-7.3, -0.5, -1e-9, 0.0, 0.2, 0.5, 3.49999, 1e6 + 0.123}) {
    const Weights w = grid_weights(x);
    double sum = 0.0, place = 0.0, second = 0.0;
    for (int k = 0; k < kNodes; ++k) {
      EXPECT_GE(w.w[k], 0.0);
      sum += w.w[k], place += w.w[k] * (w.base + k - x), second += w.w[k] * std::pow(w.base + k - x, 2);
    }
    EXPECT_NEAR(sum, 1.0, 1e-15);
    EXPECT_NEAR(place, 0.0, 1e-9);    // of spacings; at 1e6 that is round-off of x
    EXPECT_NEAR(second, 0.25, 1e-9);  // what APIC divides by
  }
}
