// Principal stresses.
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "shell/mechanics/principal.h"

using namespace sunder;
using namespace sunder::shell;

TEST(Principal, AreTheEigenvaluesAndTheCrackRunsAcrossTheHigherOne) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int k = 0; k < 1000; ++k) {
    Eigen::Matrix2d s;
    s << uniform(random), uniform(random), 0.0, uniform(random);
    s(1, 0) = s(0, 1);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> exact(s);
    const Principal p = principal(s(0, 0), s(1, 1), s(0, 1));
    EXPECT_NEAR(p.low, exact.eigenvalues()[0], 1e-15 * 4);
    EXPECT_NEAR(p.high, exact.eigenvalues()[1], 1e-15 * 4);
    EXPECT_NEAR(p.crack.norm(), 1.0, 1e-15 * 4);
    EXPECT_LT((s * p.crack - p.low * p.crack).norm(), 1e-14);  // along it acts the lower one
  }
}

TEST(Principal, OfPlainStatesAreExact) {
  const Principal pulled = principal(5.0, 0.0, 0.0);  // along x: the crack runs along y
  EXPECT_EQ(pulled.high, 5.0);
  EXPECT_EQ(pulled.low, 0.0);
  EXPECT_EQ(pulled.crack, Vec2(0, 1));
  const Principal even = principal(2.0, 2.0, 0.0);
  EXPECT_EQ(even.high, even.low);
  EXPECT_EQ(even.crack.norm(), 1.0);
  const Vec2 left = turned(Vec2(1, 0), std::acos(-1.0) / 2);
  EXPECT_LT((left - Vec2(0, 1)).norm(), 1e-15);
}
