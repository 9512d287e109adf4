#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/geometry/builders.h"
#include "shell/geometry/quadrature.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(Patch, DerivativesAreThoseOfItsPosition) {
  const Patch p = rational_patch();
  const double e = 1e-5;
  for (const Vec2& q : {Vec2(0.11, 0.7), Vec2(0.41, 0.21), Vec2(0.83, 0.55)}) {
    const auto at = [&](double du, double dv) { return p.evaluate(q + Vec2(du, dv)).x; };
    const SurfacePoint s = p.evaluate(q);
    // central differences: truncation O(e^2) = 1e-10 of third derivatives, round-off 1e-16 / e^2 = 1e-6
    EXPECT_LT((s.u - (at(e, 0) - at(-e, 0)) / (2 * e)).norm(), 1e-9);
    EXPECT_LT((s.motion.v - (at(0, e) - at(0, -e)) / (2 * e)).norm(), 1e-9);
    EXPECT_LT((s.uu - (at(e, 0) - 2 * s.motion.x + at(-e, 0)) / (e * e)).norm(), 2e-5);
    EXPECT_LT((s.vv - (at(0, e) - 2 * s.motion.x + at(0, -e)) / (e * e)).norm(), 2e-5);
    EXPECT_LT((s.uv - (at(e, e) - at(e, -e) - at(-e, e) + at(-e, -e)) / (4 * e * e)).norm(), 2e-5);
  }
}

TEST(Patch, OfAQuarterCylinderIsExact) {
  // rational quadratic arc with weights 1, sqrt(1/2), 1: a circle to round-off
  Patch p{KnotVector({0, 0, 0, 1, 1, 1}, 2, "u"), KnotVector({0, 0, 0, 1, 1, 1}, 2, "v"), {}, {}};
  for (const double z : {0.0, 0.5, 1.0})
    for (const auto& [x, y] : {std::pair{1.0, 0.0}, std::pair{1.0, 1.0}, std::pair{0.0, 1.0}}) {
      p.control_points.emplace_back(x, y, z);
      p.weights.push_back(x == y ? std::sqrt(0.5) : 1.0);
    }
  for (double u = 0.0; u <= 1.0; u += 0.125) EXPECT_NEAR(p.evaluate({u, 0.3}).x.head<2>().norm(), 1.0, 1e-15);
}

TEST(RefinedAtLeast, CutsLongSpansMoreOftenAndKeepsTheSurface) {
  const Patch p = rational_patch();  // spans of 0.3, 0.2 and 0.5; 0.4 and 0.6
  const Patch fine = refined_at_least(p, 5, 1);
  EXPECT_EQ(fine.knots_u.spans(), 2 + 1 + 3);
  EXPECT_EQ(fine.knots_v.spans(), 2);
  for (int s = 0; s < fine.knots_u.spans(); ++s) EXPECT_LE(fine.knots_u.span_length(s), 0.2 + 1e-15);
  for (const Vec2& q : {Vec2(0.11, 0.7), Vec2(0.41, 0.21), Vec2(0.83, 0.55)})
    EXPECT_LT((fine.evaluate(q).x - p.evaluate(q).x).norm(), 1e-15);  // lengths of 1: round-off
  EXPECT_EQ(refined_at_least(plate(1, 1, 3, 1, Vec3::Zero(), Quat::Identity()), 3, 4).columns(), 3 + 2);
  EXPECT_THROW(refined_at_least(p, 0, 1), Error);
}

TEST(KnotVector, RefusesWhatIsNoOpenQuadratic) {
  EXPECT_THROW(KnotVector({0, 0, 0, 1, 0.5, 2, 2, 2}, 2, "u"), Error);
  EXPECT_THROW(KnotVector({0, 0, 1, 1, 1}, 2, "u"), Error);
  EXPECT_THROW(KnotVector({0, 0, 0, 0.5, 0.5, 0.5, 1, 1, 1}, 2, "u"), Error);
  EXPECT_THROW(KnotVector({0, 0, 0, std::nan(""), 1, 1, 1}, 2, "u"), Error);
}

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

namespace {
double energy_density(const Sym2<double>& c, const Sym2<double>& a, const Elasticity& e) {
  return plane_stress_energy<double>(plane_stress<double>(c, a, e), c, a, e);
}
}  // namespace

TEST(PlaneStress, IsTwiceTheDerivativeOfItsEnergyAtSmallAndLargeStrain) {
  for (const double nu : {0.0, 0.22, 0.45, -0.3})
    for (const double stretch : {1.0, 1.01, 1.0199, 1.0201, 1.5, 0.6}) {  // across the switch to logarithms
      const Elasticity e = elasticity(1.0, nu);
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
      const Elasticity e = elasticity(1.0, nu);
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
      const Elasticity e = elasticity(1.0, nu);
      const PlaneStress<double> p = plane_stress<double>({area, area, 0.0}, {1.0, 1.0, 0.0}, e);
      const double residual =
          e.mu * (p.stretch2 - 1.0) + 0.5 * e.lambda * std::log(p.stretch2) + e.lambda * std::log(area);
      EXPECT_NEAR(residual, 0.0, 1e-13 * (e.mu + std::abs(e.lambda))) << nu << " " << area;
    }
}

TEST(PlaneStress, HasTheModuliOfLinearElasticityAtSmallStrain) {
  const double nu = 0.3, strain = 1e-7;
  const Elasticity e = elasticity(2e11, nu);
  const PlaneStress<double> p = plane_stress<double>({1 + 2 * strain, 1, 0}, {1, 1, 0}, e);
  EXPECT_NEAR(p.s.c11 / strain, 2e11 / (1 - nu * nu), 1e-5 * 2e11);  // O(strain) and round-off / strain
  EXPECT_NEAR(p.s.c22 / strain, nu * 2e11 / (1 - nu * nu), 1e-5 * 2e11);
}
