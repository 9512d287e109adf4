// The law of shear and compression through the thickness.
#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "shell/mechanics/fibre.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

const FibreLaw kLaw{3e5, 2e5, 0.4};

}  // namespace

TEST(FibreLaw, ReturnsToTheConeExactly) {
  std::mt19937_64 random(1);
  int inside = 0, beyond = 0, slipped = 0;
  for (int i = 0; i < 100000; ++i) {
    const Vec3 a(uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5), uniform(random, 0.1, 1.2));
    const Vec3 b = fibre_return(kLaw, a);
    const double shear = a.head<2>().norm(), most = kLaw.friction * kLaw.compression * (1.0 - a.z()) * (1.0 - a.z());
    if (a.z() > 1.0) {
      EXPECT_EQ(b, Vec3::UnitZ());
      ++beyond;
    } else if (kLaw.shear * shear <= most) {
      EXPECT_EQ(b, a);
      ++inside;
    } else {
      EXPECT_NEAR(kLaw.shear * b.head<2>().norm(), most, 1e-14 * kLaw.shear);
      EXPECT_EQ(b.z(), a.z());
      EXPECT_NEAR(b.x() * a.y(), b.y() * a.x(), 1e-16);  // the same direction
      ++slipped;
    }
    EXPECT_LE(fibre_energy(kLaw, b), fibre_energy(kLaw, a) * (1.0 + 1e-15));
    const Vec3 again = fibre_return(kLaw, b);  // but for round-off of a division
    EXPECT_LT((again - b).norm(), 1e-15);
  }
  EXPECT_GT(std::min({inside, beyond, slipped}), 1000);
}

TEST(FibreLaw, StressIsTheGradientOfEnergy) {
  std::mt19937_64 random(2);
  constexpr double kEps = 1e-5;  // central differences: error eps^2 k/3, and round-off 1e-16/eps of the energy
  for (int i = 0; i < 1000; ++i) {
    const Vec3 a(uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5), uniform(random, 0.1, 1.2));
    Vec3 slope;
    for (int d = 0; d < 3; ++d)
      slope[d] =
          (fibre_energy(kLaw, a + kEps * Vec3::Unit(d)) - fibre_energy(kLaw, a - kEps * Vec3::Unit(d))) / (2.0 * kEps);
    EXPECT_LT((slope - fibre_stress(kLaw, a)).norm(), 1e-9 * kLaw.compression);
  }
}
