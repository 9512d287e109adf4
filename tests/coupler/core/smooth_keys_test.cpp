// Smooth curves through values at given times.
#include <algorithm>

#include <gtest/gtest.h>

#include "coupler/core/smooth_keys.h"

using namespace sunder;

namespace {

TEST(HermiteWeights, GiveACubicExactly) {
  const auto x = [](double t) { return 1.0 - 2.0 * t + 3.0 * t * t - t * t * t; };
  const auto slope = [](double t) { return -2.0 + 6.0 * t - 3.0 * t * t; };
  const std::vector<double> times{0.0, 0.5, 2.0};
  for (const double t : {0.0, 0.1, 0.5, 0.9, 1.7, 2.0}) {
    const HermiteWeights w = hermite_weights(times, t);
    const int next = std::min(w.key + 1, 2);
    EXPECT_NEAR(w.a * x(times[w.key]) + w.b * slope(times[w.key]) + w.c * x(times[next]) + w.d * slope(times[next]),
                x(t), 1e-15);
  }
  EXPECT_EQ(hermite_weights(times, -1.0).key, 0);
  EXPECT_EQ(hermite_weights(times, 3.0).key, 2);
  EXPECT_EQ(hermite_weights(times, 3.0).a, 1.0);
}

TEST(SmoothSlope, IsThatOfAParabolaAndZeroWhereTheCurveTurnsBack) {
  // x = t^2 at 0.5, 1 and 1.25
  EXPECT_NEAR(smooth_slope({1.5, 0, 0}, {2.25, 0, 0}, 0.5, 0.25).x(), 2.0, 1e-15);
  EXPECT_TRUE(smooth_slope({1, 0, 0}, {-1, 0, 0}, 1, 1).isZero(0.0));
  EXPECT_TRUE(smooth_slope({0, 0, 0}, {1, 0, 0}, 1, 1).isZero(0.0));
  EXPECT_NEAR(smooth_slope({0.1, 0, 0}, {9, 0, 0}, 1, 1).norm(), 0.3, 1e-15);
}

}  // namespace
