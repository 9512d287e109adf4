// Mass for elements that limit the step: where it goes, and what it does to the shell.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "shell/geometry/builders.h"
#include "shell/solver/statics/modes.h"
#include "shell/solver/stepping/mass_scaling.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/coupler/narrow_sheet.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

double largest_of(const std::vector<double>& v) { return *std::max_element(v.begin(), v.end()); }

/// Largest eigenvalue of M^-1 K of the free shell [1/s^2].
double assembled(const ShellModel& m) {
  ShellState s = make_state(m, Vec3::Zero(), 0);
  return std::pow(2.0 / stable_step(m, s, kStepIterations, 1, true), 2);
}

Patch flat(const std::vector<double>& u, const std::vector<double>& v) {
  Patch p{KnotVector(u, 2, "u"), KnotVector(v, 2, "v"), {}, {}};
  for (int k = 0; k < p.columns() * p.rows(); ++k)
    p.control_points.emplace_back(p.greville(k).x(), p.greville(k).y(), 0.0), p.weights.push_back(1.0);
  return p;
}

/// A bar of 2 m that moves along itself only, held at both ends, with two narrow elements in the middle.
ShellModel bar(int columns, double narrow) {
  ShellMaterial q = glass();
  q.poisson_ratio = 0.0;
  Support sides, ends;
  sides.axes = {false, true, true}, sides.clamped = false;
  sides.regions.push_back({Vec2(-1.0, -1.0), Vec2(3.0, 3.0)});
  ends.edges = kUMin | kUMax, ends.clamped = false, ends.axes = {true, false, false};
  return make_shell("bar", flat(narrow_sheet::knots_x(columns, narrow), narrow_sheet::even_knots(0.2, 2)), 0.01, q, 2,
                    2, {sides, ends});
}

double sum_of(const std::vector<double>& v) {
  double sum = 0.0;
  for (const double x : v) sum += x;
  return sum;
}

std::vector<ShellModel> of_one_element() {
  const auto one = [](const Patch& p, double thickness, ShellMaterial q = glass(), const ThicknessFactor& f = {}) {
    return make_shell("one", p, thickness, q, 2, p.degree(), {}, {}, {}, f);
  };
  ShellMaterial laminate = glass(), projected = glass();
  laminate.interlayer = {0.004, 1100.0, 1e8, 0.4};
  projected.stress_model = model_of<PaperProjection>;
  const Patch square = plate(0.1, 0.07, 1, 1, Vec3::Zero(), Quat::Identity());
  return {
      one(square, 0.01),
      one(plate(0.1, 0.07, 1, 1, Vec3(1, 2, 3), Quat(0.5, 0.5, -0.5, 0.5), 3), 0.01),
      one(cylinder(0.2, 0.1, 0.4, 1, 1), 1e-3),
      one(sphere(0.2, 0.4, 0.3, 0.8, 1, 1, 3), 1e-3),
      one(square, 0.01, laminate),
      one(square, 0.01, projected),
      one(square, 0.01, glass(), [](const Patch& p, const Vec2& at) { return 1.0 + 0.5 * at.x() / p.knots_u.end(); })};
}

}  // namespace

// The shell of one element is its element. Differences of forces are exact to 1e-6; layers of a curved shell lie at
// other radii than the middle, which changes stiffness by (thickness / 2 radius)^2, below 1e-5.
TEST(ElementEigenvalues, OfOneElementAreThatOfTheShell) {
  for (const ShellModel& m : of_one_element()) {
    const std::vector<double> found = element_eigenvalues(m);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NEAR(found[0] / assembled(m), 1.0, 1e-4);
  }
}

TEST(ElementEigenvalues, BoundTheShell) {
  ShellMaterial q = glass();
  for (const ShellModel& m :
       {make_shell("flat", flat(narrow_sheet::knots_x(8, 0.25), narrow_sheet::even_knots(1.0, 4)), 0.01, q, 2, 2, {}),
        make_shell("round", cylinder(0.5, 1.0, 1.2, 8, 10), 1e-3, q, 2, 2, {}),
        make_shell("curved", rational_patch(), 1e-3, q, 2, 2, {}),
        make_shell("cubic", cubic_patch(), 1e-3, q, 2, 3, {})})
    EXPECT_GE(largest_of(element_eigenvalues(m)), assembled(m) * (1.0 - 1e-5)) << m.name;
}

TEST(ElementEigenvalues, DoNotDependOnWhereTheElementIs) {
  const auto of = [](const Patch& p) { return element_eigenvalues(make_shell("p", p, 0.01, glass(), 2, 2, {})); };
  const Patch patch = rational_patch();
  const std::vector<double> here = of(patch), there = of(placed(patch, Vec3(3, -2, 1), Quat(0.5, 0.5, -0.5, 0.5)));
  ASSERT_EQ(here.size(), there.size());
  for (std::size_t k = 0; k < here.size(); ++k) EXPECT_NEAR(there[k] / here[k], 1.0, 1e-6);
}

TEST(AddMass, GivesItToSmallElementsOnlyAndAllThatItTells) {
  ShellModel m = make_shell("flat", flat(narrow_sheet::knots_x(20, 0.25), narrow_sheet::even_knots(1.0, 10)), 0.01,
                            glass(), 2, 2, {});
  const std::vector<double> own = m.mass, lambda = element_eigenvalues(m);
  const double area = m.mass[m.tables.slot(0)] / m.mass_per_area(m.tables.slot(0)), mobility = m.largest_mobility;
  const double limit = 0.4 * largest_of(lambda);
  const double told = add_mass(m, own, lambda, limit);
  EXPECT_GT(told, 0.0);
  EXPECT_NEAR(sum_of(m.mass) - sum_of(own), told, 1e-12 * sum_of(own));
  std::vector<char> reached(own.size(), 0);
  const int narrow = 10;  // the first of the two narrow columns
  for (int f = 0; f < m.tables.spans_v; ++f)
    for (int e = 0; e < m.tables.spans_u; ++e) {
      if (lambda[f * m.tables.spans_u + e] <= limit) continue;
      EXPECT_TRUE(e == narrow || e == narrow + 1) << e;
      for (int k = 0; k < 9; ++k) reached[(f + k / 3) * m.tables.stride + e + k % 3] = 1;
    }
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    EXPECT_GE(m.mass[slot], own[slot]) << i;
    EXPECT_EQ(m.mass[slot] == own[slot], reached[slot] == 0) << i;
    EXPECT_NEAR(m.mass[slot] / m.mass_per_area(slot), own[slot] / (m.material.density * m.thickness), 1e-12 * area)
        << "the area that a control point stands for";
  }
  EXPECT_LE(m.largest_mobility, mobility);
  EXPECT_EQ(add_mass(m, own, lambda, 1.01 * largest_of(lambda)), 0.0);
  EXPECT_EQ(m.mass, own);
}

TEST(AddMass, LeavesNoElementAboveTheLimit) {
  ShellModel m = make_shell("flat", flat(narrow_sheet::knots_x(20, 0.25), narrow_sheet::even_knots(1.0, 10)), 0.01,
                            glass(), 2, 2, {});
  const std::vector<double> own = m.mass, lambda = element_eigenvalues(m);
  for (const double share : {0.7, 0.4, 0.1}) {
    add_mass(m, own, lambda, share * largest_of(lambda));
    EXPECT_LE(assembled(m), share * largest_of(lambda) * (1.0 + 1e-6));
  }
}

TEST(AddMass, KeepsWholeMassAndLightensNothingBesideAHole) {
  const Patch p = plate(1.0, 1.0, 12, 12, Vec3::Zero(), Quat::Identity());
  const TrimLoops loops = [&] {
    std::vector<Vec2> ring;
    for (int k = 0; k <= 40; ++k)
      ring.emplace_back(0.5 + 0.23 * std::cos(2.0 * std::numbers::pi * (k % 40) / 40.0),
                        0.5 + 0.23 * std::sin(2.0 * std::numbers::pi * (k % 40) / 40.0));
    return TrimLoops(Vec2::Zero(), Vec2::Ones(), {{ring, true}});
  }();
  ShellModel m = make_shell("holed", p, 0.01, glass(), 2, 2, {}, {}, loops);
  const std::vector<double> own = m.mass;
  const double told = add_mass(m, own, element_eigenvalues(m), 0.5 * largest_of(element_eigenvalues(m)));
  EXPECT_GT(told, 0.0);
  EXPECT_NEAR(sum_of(m.mass) - sum_of(own), told, 1e-12 * sum_of(own));
  for (std::size_t i = 0; i < own.size(); ++i) EXPECT_GE(m.mass[i], own[i]);
}

// A bar of two ends of length l and a middle of length b whose density is f times larger: k cot(k l) = k' tan(k' b /
// 2), k = omega / c, k' = sqrt(f) k. Lumping smears the middle by less than an element: its effect on the frequency,
// which is of first order in b, is met to (h / L)^2, and the share by which it is lowered to a hundredth.
TEST(AddMass, LowersTheFirstModeOfABarAsTheClosedFormSays) {
  ShellModel m = bar(40, 0.4);
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const JoinedShells joined{{{&m, &s}}, {0}, nullptr, {Vec3::Zero()}};
  const Vibrations vibrations(joined, 1);
  const double before = vibrations.lowest(1).modes[0].in_run;
  const double c = std::sqrt(m.material.youngs_modulus / m.material.density), length = narrow_sheet::kLength;
  EXPECT_NEAR(before, c / (2.0 * length), 2e-3 * before);  // lumping: (k h)^2 / 8 at most
  const std::vector<double> lambda = element_eigenvalues(m);
  add_mass(m, std::vector<double>(m.mass), lambda, 0.3 * largest_of(lambda));
  // the factor of the narrow elements, 1/0.3, and of wide ones
  const double narrow = 1.0 / 0.3;  // factor of the density in narrow elements
  s.motion.mass = m.mass;
  const double after = vibrations.lowest(1).modes[0].in_run;
  const double b = 2.0 * 0.4 * length / 40.8, l = 0.5 * (length - b);
  double low = 0.5 * std::numbers::pi * c / length, high = std::numbers::pi * c / length;
  for (int k = 0; k < 60; ++k) {
    const double omega = 0.5 * (low + high), at = omega / c, in = std::sqrt(narrow) * at;
    (at / std::tan(at * l) > in * std::tan(0.5 * in * b) ? low : high) = omega;
  }
  const double exact = 1.0 - low / (std::numbers::pi * c / length);
  EXPECT_GT(exact, 0.02);
  EXPECT_NEAR((1.0 - after / before) / exact, 1.0, 0.02);
}

// Added mass only lowers frequencies (Courant and Fischer), to 1e-9 of round-off in eigenvalues.
TEST(AddMass, RaisesNoFrequency) {
  ShellModel m = make_shell("curved", rational_patch(), 0.01, glass(), 2, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const JoinedShells joined{{{&m, &s}}, {0}, nullptr, {Vec3::Zero()}};
  const Vibrations vibrations(joined, 1);
  const ModeSet before = vibrations.lowest(12);
  EXPECT_EQ(before.rigid, 6);
  const std::vector<double> lambda = element_eigenvalues(m);
  add_mass(m, std::vector<double>(m.mass), lambda, 0.2 * largest_of(lambda));
  s.motion.mass = m.mass;
  const ModeSet after = vibrations.lowest(12);
  ASSERT_EQ(after.modes.size(), before.modes.size());
  for (std::size_t k = 0; k < before.modes.size(); ++k)
    EXPECT_LE(after.modes[k].in_run, before.modes[k].in_run * (1.0 + 1e-9)) << k;
  EXPECT_LT(after.modes[0].in_run, before.modes[0].in_run);
}
