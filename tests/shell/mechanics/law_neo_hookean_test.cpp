// Plane stress: the thickness that makes it so, and its moduli.
#include <cmath>

#include <gtest/gtest.h>

#include "shell/mechanics/laws.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

double energy_density(const Sym2<double>& c, const Sym2<double>& a, const Elasticity& e) {
  return plane_stress_energy<double>(plane_stress<double>(c, a, e), c, a, e);
}

}  // namespace

TEST(PlaneStress, IsTwiceTheDerivativeOfItsEnergyAtSmallAndLargeStrain) {
  for (const double nu : {0.0, 0.22, 0.45, -0.3})
    for (const double stretch : {1.0, 1.01, 1.0199, 1.0201, 1.5, 0.6}) {  // across the switch to logarithms
      const Elasticity e = elasticity({1.0, nu});
      const Sym2<double> a{1.1, 0.9, 0.2};
      const Sym2<double> c{1.1 * stretch, 0.9 * stretch + 0.01, 0.2 * stretch - 0.003};
      const PlaneStress<double> p = plane_stress<double>(c, a, e);
      const double h = 1e-5;
      const auto slope = [&](double d11, double d22, double d12) {
        return (energy_density({c.c11 + h * d11, c.c22 + h * d22, c.c12 + h * d12}, a, e) -
                energy_density({c.c11 - h * d11, c.c22 - h * d22, c.c12 - h * d12}, a, e)) /
               (2 * h);
      };
      // S^ab = 2 d psi / d C_ab; C_12 stands twice in the tensor
      EXPECT_NEAR(p.s.c11, 2.0 * slope(1, 0, 0), 1e-9) << nu << " " << stretch;
      EXPECT_NEAR(p.s.c22, 2.0 * slope(0, 1, 0), 1e-9) << nu << " " << stretch;
      EXPECT_NEAR(p.s.c12, slope(0, 0, 1), 1e-9) << nu << " " << stretch;
    }
}

TEST(PlaneStress, FindsTheThicknessToRoundOffOnBothSidesOfTheSwitch) {
  for (const double nu : {-0.9, -0.3, 0.0, 0.22, 0.3, 0.45, 0.49})
    for (const double z : {-0.0201, -0.0199, -0.01, -1e-6, 0.0, 1e-6, 0.005, 0.0199, 0.0201}) {
      const Elasticity e = elasticity({1.0, nu});
      const double area = std::sqrt((1.0 + z) / (1.0 - z));
      const PlaneStress<double> p = plane_stress<double>({area, area, 0.0}, {1.0, 1.0, 0.0}, e);
      const double residual =
          e.mu * (p.stretch2 - 1.0) + 0.5 * e.lambda * std::log(p.stretch2) + e.lambda * std::atanh(z);
      // of the largest term; what the series leaves out at its end is (2 z)^11
      EXPECT_NEAR(residual, 0.0, (1e-15 + 4e-16) * (e.mu + std::abs(e.lambda))) << nu << " " << z;
      EXPECT_NEAR(volume_ratio<double>(p, e), area * std::sqrt(p.stretch2), 2e-15) << nu << " " << z;
    }
}

TEST(PlaneStress, FindsTheThicknessHoweverFarTheSheetIsStretched) {
  for (const double nu : {-0.5, 0.0, 0.3, 0.45, 0.49})
    for (const double area : {0.6, 1.5, 3.0, 5.0, 20.0}) {
      const Elasticity e = elasticity({1.0, nu});
      const PlaneStress<double> p = plane_stress<double>({area, area, 0.0}, {1.0, 1.0, 0.0}, e);
      const double residual =
          e.mu * (p.stretch2 - 1.0) + 0.5 * e.lambda * std::log(p.stretch2) + e.lambda * std::log(area);
      EXPECT_NEAR(residual, 0.0, 1e-13 * (e.mu + std::abs(e.lambda))) << nu << " " << area;
    }
}

TEST(PlaneStress, HasTheModuliOfLinearElasticityAtSmallStrain) {
  const double nu = 0.3, strain = 1e-7;
  const Elasticity e = elasticity({2e11, nu});
  const PlaneStress<double> p = plane_stress<double>({1 + 2 * strain, 1, 0}, {1, 1, 0}, e);
  EXPECT_NEAR(p.s.c11 / strain, 2e11 / (1 - nu * nu), 1e-5 * 2e11);  // O(strain) and round-off / strain
  EXPECT_NEAR(p.s.c22 / strain, nu * 2e11 / (1 - nu * nu), 1e-5 * 2e11);
}

// With Poisson's ratio -0.5 there is no plane stress below 0.446 of the area: mu (s - 1) + lambda/2 ln s = -lambda ln
// J.
TEST(PlaneStress, OfAuxeticsHasAnAnswerDownToTheLeastArea) {
  const Elasticity e = elasticity({1e9, -0.5});
  const double least = e.least_log_area();
  EXPECT_NEAR(std::exp(least), 0.4463, 1e-4);
  for (const double log_area : {0.9 * least, 0.5 * least, -0.01, 0.3, 1.0}) {
    const double root = std::exp(log_area);
    const PlaneStress<double> p = plane_stress<double>({root, root, 0}, {1, 1, 0}, e);
    EXPECT_NEAR(e.mu * (p.stretch2 - 1.0) + 0.5 * e.lambda * std::log(p.stretch2) + e.lambda * log_area, 0.0,
                1e-9 * e.mu)
        << log_area;
  }
  EXPECT_TRUE(std::isinf(elasticity({1e9, 0.3}).least_log_area()));
}
