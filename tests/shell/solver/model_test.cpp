// The constant part of a shell: masses, speeds of waves, and which edges are clamped.
#include <cmath>
#include <numeric>
#include <string>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/geometry/builders.h"
#include "shell/solver/model.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

double mass_of(const ShellModel& m) { return std::accumulate(m.mass.begin(), m.mass.end(), 0.0); }

/// The Rayleigh equation in x = (c / c_s)^2, by bisection (Achenbach, Wave Propagation in Elastic Solids,
/// section 5.11).
double rayleigh_over_shear(double poisson) {
  const double k = (1.0 - 2.0 * poisson) / (2.0 * (1.0 - poisson));  // (c_s / c_l)^2
  const auto f = [&](double x) { return std::pow(2.0 - x, 2) - 4.0 * std::sqrt((1.0 - x) * (1.0 - k * x)); };
  double low = 0.1, high = 1.0;
  for (int i = 0; i < 60; ++i) (f(0.5 * (low + high)) < 0.0 ? low : high) = 0.5 * (low + high);
  return std::sqrt(low);
}

}  // namespace

TEST(ShellModel, WeighsDensityTimesThicknessTimesArea) {
  const ShellModel flat = brittle_sheet(7);
  EXPECT_NEAR(mass_of(flat), 2500 * 0.004 * 0.04, 1e-13);
  const ShellModel round = make_shell("c", cylinder(0.3, 0.5, 1.2, 12, 6), 0.002, glass(), 2, 3, {});
  // the area of the arc by three points an element: 1e-9 and less
  EXPECT_NEAR(mass_of(round), 2500 * 0.002 * 0.3 * 1.2 * 0.5, 1e-8 * mass_of(round));
  for (int i = 0; i < round.control_points(); ++i) EXPECT_GT(round.mass[round.tables.slot(i)], 0.0) << i;
}

TEST(ShellModel, RayleighSpeedIsThatOfItsEquation) {
  for (const double nu : {0.1, 0.22, 0.3, 0.45}) {
    ShellMaterial m = glass();
    m.poisson_ratio = nu;
    const ShellModel s = make_shell("p", plate(1, 1, 4, 4, Vec3::Zero(), Quat::Identity()), 0.004, m, 2, 2, {});
    const double shear = std::sqrt(m.youngs_modulus / (2.0 * (1.0 + nu)) / m.density);
    EXPECT_NEAR(s.rayleigh_speed() / shear, rayleigh_over_shear(nu), 7e-3) << nu;  // the fit is 0.6 % off at 0.1
    EXPECT_NEAR(s.wave_speed(), std::sqrt(m.youngs_modulus / (1.0 - nu * nu) / m.density), 1e-9) << nu;
  }
}

TEST(ShellModel, RespondsInThePassageOfASpacingOrOfItsThickness) {
  const double shear = std::sqrt(70e9 / (2.0 * 1.22) / 2500);
  const ShellModel fine = brittle_sheet(100), coarse = brittle_sheet(10);  // 2 mm and 20 mm; 4 mm thick
  EXPECT_NEAR(fine.response_time(), 0.004 / shear, 1e-15);
  EXPECT_NEAR(coarse.response_time(), 0.02 / coarse.wave_speed(), 1e-15);
}

TEST(ShellModel, KnowsTheEdgesThatAreHeldWithTheirSlopes) {
  const auto clamped = [](const Support& s) {
    return make_shell("p", plate(1, 1, 6, 6, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {s}).clamped;
  };
  Support s;
  s.edges = kUMin | kVMax;
  EXPECT_EQ(clamped(s), kUMin | kVMax);
  s.clamped = false;
  EXPECT_EQ(clamped(s), 0);
  s.clamped = true, s.axes = {true, true, false};
  EXPECT_EQ(clamped(s), 0);
}

TEST(ShellModel, PaddingHasNeitherMassNorPlace) {
  const ShellModel m = brittle_sheet(5);
  std::vector<char> real(m.tables.component_stride, 0);
  for (int i = 0; i < m.control_points(); ++i) {
    real[m.tables.slot(i)] = 1;
    EXPECT_EQ(m.tables.control_point(m.tables.slot(i)), i);
    EXPECT_EQ(m.parameter_of_slot[m.tables.slot(i)], m.parameter[i]);
  }
  for (int slot = 0; slot < m.tables.component_stride; ++slot)
    if (!real[slot]) {
      EXPECT_EQ(m.mass[slot], 0.0) << slot;
    }
}

TEST(ShellModel, RefusesAPatchThatHasNoArea) {
  Patch p = plate(1, 1, 4, 4, Vec3::Zero(), Quat::Identity());
  for (Vec3& x : p.control_points) x.y() = 0.0;
  try {
    make_shell("flat", p, 0.004, glass(), 2, 2, {});
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("shell 'flat'"), std::string::npos) << e.what();
  }
}
