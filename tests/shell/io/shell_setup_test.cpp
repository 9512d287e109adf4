// Warnings about shells that do not do what their scene asks for.
#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "shell/io/shell_setup.h"
#include "shell/mechanics/layers_yielding.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kFlow = 2e8;  // [Pa]

ShellSetup metal(double strength, double hardening = 0.0) {
  ShellSetup s{brittle_sheet(8)};
  s.material = "tin", s.fracture.mode = FractureMode::kTips;
  s.model.material.yield_stress = kFlow, s.model.material.hardening_modulus = hardening;
  s.model.material.strength = strength, s.model.material.weibull_modulus = 0.0;
  return s;
}

}  // namespace

TEST(NeverBreaks, TellsAMetalThatFlowsBelowItsStrength) {
  const std::string told = never_breaks({metal(kFlow), metal(1.2 * kFlow)});
  for (const char* part : {"never breaks by itself: material 'tin' flows at 2e+08 Pa without hardening",
                           "no stress is above 2.309e+08 Pa, and its strength is 2.4e+08 Pa",
                           "give it a hardening_modulus, or a strength up to its yield_stress"})
    EXPECT_NE(told.find(part), std::string::npos) << told;
  EXPECT_EQ(told.find("; shell"), std::string::npos) << told;  // of one shell
}

TEST(NeverBreaks, SaysNothingWhereItMayBreakOrNeedNot) {
  EXPECT_EQ(never_breaks({metal(1.1 * kFlow)}), "");       // pulled along two axes it does
  EXPECT_EQ(never_breaks({metal(1.2 * kFlow, 1e7)}), "");  // hardening gets there
  EXPECT_EQ(never_breaks({metal(0.0)}), "");               // nor shall it
  ShellSetup cut = metal(1.2 * kFlow);
  cut.fracture.mode = FractureMode::kNone;
  EXPECT_EQ(never_breaks({cut}), "");
  ShellSetup scattered = metal(1.2 * kFlow);
  scattered.model.material.weibull_modulus = 8.0;
  EXPECT_EQ(never_breaks({scattered}), "");
  ShellSetup painted = metal(1.2 * kFlow);
  painted.model.strength_factor.assign(4, 1.0F), painted.model.strength_factor[2] = 0.5F;
  EXPECT_EQ(never_breaks({painted}), "");
}

// The bound that the warning names: in plane stress von Mises allows a principal stress of 2 / sqrt(3) yield stresses.
TEST(NeverBreaks, NoPrincipalStressExceedsTheBound) {
  constexpr double kYoung = 2e11, kPoisson = 0.3;
  const Yielding law{kFlow, 0.0, kYoung, kPoisson};
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> strain(-4e-3, 4e-3);
  double most = 0.0;
  for (int k = 0; k < 4000; ++k) {
    PlasticState<double> s{};
    const Sym2<double> c{1.0 + strain(random), 1.0 + strain(random), strain(random)}, rest{1.0, 1.0, 0.0};
    return_to_yield<double>(s, c, rest, law);
    const Sym2<double> a{1.0 + s.change.c11, 1.0 + s.change.c22, s.change.c12};
    const PlaneStress<double> p = plane_stress<double>(c, a, elasticity({kYoung, kPoisson}));
    const double mean = 0.5 * (p.s.c11 + p.s.c22);
    most = std::max(most, mean + std::hypot(0.5 * (p.s.c11 - p.s.c22), p.s.c12));
  }
  const double bound = 2.0 / std::sqrt(3.0) * kFlow;
  EXPECT_LT(most, 1.01 * bound);  // stress of large strain, some per cent of strains of 4e-3 off
  EXPECT_GT(most, 0.98 * bound);
}
