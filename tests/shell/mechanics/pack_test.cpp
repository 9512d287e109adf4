// Doubles that are worked on at once do what one alone does.
#include <bit>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "shell/mechanics/pack.h"

using namespace sunder::shell;

TEST(Pack, SplitsNumbersAsOneAloneDoes) {
  std::mt19937_64 random(1);
  for (int k = 0; k < 10000; ++k) {
    Pack4 a, mantissa, exponent;
    for (int i = 0; i < 4; ++i) {
      double x;
      do x = std::abs(std::bit_cast<double>(random()));
      while (!std::isnormal(x) || x > 1e308);  // at the very end of the range the packed exponent overflows
      a[i] = x;
    }
    split_exponent(a, mantissa, exponent);
    for (int i = 0; i < 4; ++i) {
      double m, e;
      split_exponent(a[i], m, e);
      EXPECT_EQ(mantissa[i], m) << a[i];
      EXPECT_EQ(exponent[i], e) << a[i];
      EXPECT_EQ(std::ldexp(m, static_cast<int>(e)), a[i]);
      EXPECT_TRUE(m >= std::sqrt(0.5) && m < std::sqrt(2.0)) << a[i];
    }
  }
}

TEST(Pack, LogarithmIsThatOfTheStandardLibrary) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> exponent(-300.0, 300.0), near(-0.5, 1.0);
  for (int k = 0; k < 20000; ++k) {
    const double x = k % 2 == 0 ? std::pow(10.0, exponent(random)) : 1.0 + near(random), exact = std::log(x);
    const double bound = 4e-16 + 2.3e-16 * std::abs(exact);  // 2e-16 and an ulp, and the library's half
    EXPECT_NEAR(logarithm(x), exact, bound) << x;
    EXPECT_NEAR(logarithm(splat<Pack>(x))[kLanes - 1], exact, bound) << x;
  }
  EXPECT_EQ(logarithm(1.0), 0.0);
}

TEST(Pack, LoadsSelectsAndTellsLaneByLane) {
  const double numbers[kLanes + 1] = {7, 1, -2, 3};
  const Pack a = load<Pack>(numbers + 1);  // need not be aligned
  EXPECT_EQ(a[0], 1.0);
  EXPECT_EQ(a[1], -2.0);
  const Pack positive = select(a > 0.0, a, splat<Pack>(9.0));
  EXPECT_EQ(positive[0], 1.0);
  EXPECT_EQ(positive[1], 9.0);
  EXPECT_TRUE(any(a < 0.0));
  EXPECT_FALSE(any(a < -2.0));
  double back[kLanes];
  store(back, square_root(a * a));
  EXPECT_EQ(back[1], 2.0);
}
