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
// complete at three times the shear of its strength, a tenth
const FibreLaw kWeak{1e6, 1e5, 0.5, 1e4, 2e5, 0.5};

// Shear of a fibre of full length whose stress is q times the strength.
Vec3 sheared(double q) { return {q * kWeak.shear_strength / kWeak.shear, 0.0, 1.0}; }

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

TEST(FibreDamage, FollowsShearAndPressureByTheClosedForm) {
  EXPECT_EQ(fibre_damage(kWeak, sheared(1.0), 1.0, 0.0f), 0.0f);
  EXPECT_EQ(fibre_damage(kWeak, sheared(2.0), 1.0, 0.0f), 0.75f);
  EXPECT_EQ(fibre_damage(kWeak, sheared(3.0), 1.0, 0.0f), 1.0f);
  EXPECT_EQ(fibre_damage(kWeak, sheared(30.0), 1.0, 0.0f), 1.0f);
  EXPECT_EQ(fibre_damage(kWeak, sheared(4.0), 2.0, 0.0f), 0.75f);  // twice as strong
  EXPECT_EQ(fibre_damage(kWeak, sheared(2.0), 1.0, 0.9f), 0.9f);   // it was more
  EXPECT_NEAR(complete_shear(kWeak), 3.0 * kWeak.shear_strength, 1e-15 * kWeak.shear_strength);
  const auto pressed = [](double pressure) { return Vec3(0, 0, 1.0 - std::sqrt(pressure / kWeak.compression)); };
  EXPECT_EQ(fibre_damage(kWeak, pressed(1.99e5), 1.0, 0.0f), 0.0f);
  EXPECT_NEAR(fibre_damage(kWeak, pressed(4e5), 1.0, 0.0f), 0.75f, 1e-7);  // single precision
  EXPECT_EQ(fibre_damage(kWeak, pressed(6.01e5), 1.0, 0.0f), 1.0f);
  FibreLaw shear_alone = kWeak;
  shear_alone.crushing_strength = FibreLaw{}.crushing_strength;
  EXPECT_EQ(fibre_damage(shear_alone, pressed(8e5), 1.0, 0.0f), 0.0f);
  EXPECT_EQ(fibre_damage(kWeak, Vec3(1.0, 0.0, 1.01), 1.0, 0.0f), 0.0f);  // nothing touches it
  // the larger of both decides
  EXPECT_EQ(fibre_damage(kWeak, Vec3(0.2, 0.0, pressed(3e5).z()), 1.0, 0.0f), 0.75f);
}

// tau_f^2 (1 + H) / (2 gamma H); the sum by the trapezoidal rule, whose error is that of two kinks.
TEST(FibreDamage, ShearTakesItsFractureEnergyWithAndWithoutHealing) {
  constexpr int kSteps = 3000;
  for (const double factor : {1.0, 2.0}) {
    const double exact = 1500.0 * factor * factor;
    double work = 0.0, taken = 0.0, before = 0.0;
    Vec3 last = Vec3::UnitZ();
    for (int i = 1; i <= kSteps; ++i) {
      const Vec3 a = sheared(4.0 * factor * i / kSteps);
      const double c = fibre_damage(kWeak, a, factor, 0.0f);
      work += 0.5 * (fibre_stress(kWeak, last, before) + fibre_stress(kWeak, a, c)).dot(a - last);
      taken += damage_energy(kWeak, before, c, last, a);
      EXPECT_NEAR(work, taken + fibre_energy(kWeak, a, c), 1e-12 * exact) << i;  // each step exactly
      last = a, before = c;
    }
    EXPECT_EQ(before, 1.0);
    EXPECT_EQ(fibre_energy(kWeak, last, before), 0.0);
    EXPECT_NEAR(taken, exact, 1e-5 * exact) << factor;
    double healed = 0.0;  // and back
    for (int i = kSteps - 1; i >= 0; --i) {
      const Vec3 a = sheared(4.0 * factor * i / kSteps);
      const double c = fibre_damage(kWeak, a, factor, 0.0f);
      healed += damage_energy(kWeak, before, c, last, a);
      last = a, before = c;
    }
    EXPECT_EQ(before, 0.0);
    EXPECT_NEAR(healed, -taken, 1e-12 * exact);
  }
}

TEST(FibreDamage, StressIsTheGradientOfEnergyAtFixedDamage) {
  std::mt19937_64 random(3);
  constexpr double kEps = 1e-5;  // as above
  for (int i = 0; i < 1000; ++i) {
    const Vec3 a(uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5), uniform(random, 0.1, 1.2));
    const double c = uniform(random, 0.0, 1.0);
    Vec3 slope;
    for (int d = 0; d < 3; ++d)
      slope[d] = (fibre_energy(kWeak, a + kEps * Vec3::Unit(d), c) - fibre_energy(kWeak, a - kEps * Vec3::Unit(d), c)) /
                 (2.0 * kEps);
    EXPECT_LT((slope - fibre_stress(kWeak, a, c)).norm(), 1e-9 * kWeak.compression);
    EXPECT_EQ(fibre_stress(kWeak, a, c).z(), fibre_stress(kWeak, a).z());  // pressure is borne as before
  }
}

TEST(FibreDamage, TheWeakenedStressSlipsAndWhatIsSpentSlidesFreely) {
  std::mt19937_64 random(4);
  int slipped = 0, stuck = 0;
  for (int i = 0; i < 10000; ++i) {
    const Vec3 a(uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5), uniform(random, 0.1, 1.0));
    const double c = uniform(random, 0.0, 0.99), short_by = 1.0 - a.z();
    const double most = kWeak.friction * kWeak.compression * short_by * short_by;
    const Vec3 b = fibre_return(kWeak, a, c);
    const double before = fibre_stress(kWeak, a, c).head<2>().norm(), now = fibre_stress(kWeak, b, c).head<2>().norm();
    if (before <= most * (1.0 - 1e-12)) {
      EXPECT_EQ(b, a);
      ++stuck;
    } else {
      EXPECT_NEAR(now, std::min(before, most), 1e-13 * kWeak.shear);
      ++slipped;
    }
    EXPECT_LE(fibre_energy(kWeak, b, c), fibre_energy(kWeak, a, c) * (1.0 + 1e-15));
  }
  EXPECT_GT(std::min(slipped, stuck), 1000);
  for (const double factor : {1.0, 0.3})
    for (const double far : {0.31, 7.0, 1e6}) {
      const Vec3 a(0.6 * far, -0.8 * far, 0.7), b = fibre_return(kWeak, a, 1.0, factor);
      const double kept = std::min(far, factor * complete_shear(kWeak) / kWeak.shear);
      EXPECT_NEAR(b.head<2>().norm(), kept, 2e-6 * kept);
      EXPECT_EQ(b.z(), a.z());
      EXPECT_EQ(fibre_damage(kWeak, b, factor, 0.0f), 1.0f);  // round-off does not heal it
      EXPECT_EQ(fibre_energy(kWeak, b, 1.0), fibre_energy(kWeak, a, 1.0));
    }
}

// Nothing that a fibre without damage does has changed, to the bit.
TEST(FibreDamage, OfNoneLeavesTheLawAsItIs) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 a(uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5), uniform(random, 0.1, 1.2));
    const double short_by = std::max(0.0, 1.0 - a.z());
    volatile double none = 0.0;  // not known as the test is compiled
    EXPECT_EQ(fibre_energy(kWeak, a, none), fibre_energy(FibreLaw{1e6, 1e5, 0.5}, a));
    EXPECT_EQ(fibre_stress(kWeak, a, none), Vec3(1e5 * a.x(), 1e5 * a.y(), -1e6 * short_by * short_by));
    EXPECT_EQ(fibre_return(kWeak, a, none), fibre_return(FibreLaw{1e6, 1e5, 0.5}, a));
  }
}
