// The strength of a material that scatters.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kSheetSide = 1.0, kCell = 0.0125, kStrength = 50e6;

std::vector<double> strengths(double modulus, std::uint64_t seed) {
  ShellMaterial material = glass();
  material.strength = kStrength, material.weibull_modulus = modulus, material.flaw_spacing = kCell;
  const ShellModel m = make_shell("p", plate(kSheetSide, kSheetSide, 120, 120, Vec3::Zero(), Quat::Identity()), 0.004,
                                  material, 2, 2, {});
  const ShellState s = make_state(m, Vec3::Zero(), seed);
  std::vector<double> all;
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int lane = 0; lane < m.tables.spans_u; ++lane) all.push_back(s.layers.strength[m.tables.at(q, 1, 0, lane)]);
  return all;
}

// One a flaw, in rising order.
std::vector<double> flaws(double modulus, std::uint64_t seed) {
  std::vector<double> all = strengths(modulus, seed);
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

}  // namespace

TEST(Scatter, IsWeibulls) {
  for (const double modulus : {3.0, 10.0})
    for (const std::uint64_t seed : {1, 2, 3}) {
      const std::vector<double> found = flaws(modulus, seed);
      const double n = static_cast<double>(found.size());
      double apart = 0.0, sum = 0.0;  // Kolmogorov and Smirnov's
      for (std::size_t k = 0; k < found.size(); ++k) {
        const double law = 1.0 - std::exp(-std::pow(found[k] / kStrength * std::tgamma(1.0 + 1.0 / modulus), modulus));
        apart = std::max({apart, std::abs(law - k / n), std::abs(law - (k + 1) / n)});
        sum += found[k];
      }
      EXPECT_LT(apart, 1.95 / std::sqrt(n)) << modulus << ", seed " << seed;   // one in a thousand
      EXPECT_NEAR(sum / n, kStrength, 4.0 * 0.37 * kStrength / std::sqrt(n));  // a deviation at modulus 3 is 0.36
    }
}

TEST(Scatter, HasAFlawPerSquaredFlawSpacing) {
  // those that the border cuts are there with a part
  const double cells = std::pow(kSheetSide / kCell, 2), border = 4.0 * kSheetSide / kCell;
  const double n = static_cast<double>(flaws(10.0, 1).size());
  EXPECT_GT(n, cells);
  EXPECT_LT(n, cells + border);
}

TEST(Scatter, IsThatOfItsSeedAndNoneWithoutAModulus) {
  EXPECT_EQ(strengths(10.0, 7), strengths(10.0, 7));
  const std::vector<double> one = strengths(10.0, 7), other = strengths(10.0, 8);
  int same = 0;
  for (std::size_t k = 0; k < one.size(); ++k) same += one[k] == other[k];
  EXPECT_EQ(same, 0);
  for (const double strength : strengths(0.0, 7)) EXPECT_EQ(strength, kStrength);
}
