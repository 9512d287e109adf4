// Equilibrium, by Newton and by relaxation.
#include <gtest/gtest.h>

#include "shell/io/probes.h"
#include "shell/solver/forces.h"
#include "shell/solver/statics/relaxation.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(Equilibrium, NewtonAndDynamicRelaxationAgreeAndReactionsBalance) {
  Support clamp;
  clamp.edges = kUMin;
  Load load;
  load.kind = Load::Kind::kEdgeForce, load.edges = kUMax, load.force = Vec3(0, 0, 300.0);
  const ShellModel m = strip({clamp}, {load}, 0.22);
  ShellState newton = make_state(m, Vec3::Zero(), 0), relaxed = newton;
  RelaxationRules rules;
  rules.gravity = Vec3(0, 0, -9.81), rules.tolerance = 1e-8;
  const RelaxationResult a = relax(m, newton, rules);
  rules.most_newton = 0;
  const RelaxationResult b = relax(m, relaxed, rules);
  EXPECT_TRUE(a.converged);
  EXPECT_TRUE(b.converged);
  EXPECT_EQ(a.steps, 0);
  EXPECT_GT(b.steps, 100);
  const Vec3 u = displacement(m, newton, {1.0, 0.1});
  EXPECT_GT(u.z(), 1e-3);
  EXPECT_LT((displacement(m, relaxed, {1.0, 0.1}) - u).norm(), 1e-5 * u.norm());
  // 60 N up, the weight of 2500 kg/m^3 over 0.2 m^2 of 1 cm down
  EXPECT_NEAR(reaction(m, newton, rules.gravity).z(), 0.2 * 0.01 * 2500 * 9.81 - 60.0, 1e-5);
}

namespace {

ShellModel thin_strip(double thickness, const std::vector<Support>& supports, const Load& load, int elements = 20) {
  ShellMaterial m;
  m.density = 1.0, m.youngs_modulus = 21e6, m.poisson_ratio = 0.0;
  return make_shell("thin", plate(1.0, 0.2, elements, 4, Vec3(0.5, 0.1, 0), Quat::Identity()), thickness, m, 2, 2,
                    supports, {load});
}

Support clamp_at_the_root() {
  Support clamp;
  clamp.edges = kUMin;
  return clamp;
}

}  // namespace

// The load is so small that round-off of positions of 1 m, times the stiffness against stretching, exceeds the
// tolerance of it. Beam: w = P L^3/(3 E I), P = 1e-7 N, I = b h^3/12.
TEST(Equilibrium, OfASmallLoadIsFoundDownToRoundOff) {
  Load load;
  load.kind = Load::Kind::kEdgeForce, load.edges = kUMax, load.force = Vec3(0, 0, 5e-7);
  const ShellModel m = thin_strip(0.01, {clamp_at_the_root()}, load);
  ShellState s = make_state(m, Vec3::Zero(), 0);
  RelaxationRules rules;
  rules.tolerance = 1e-12;
  const RelaxationResult r = relax(m, s, rules);
  EXPECT_TRUE(r.converged);
  EXPECT_TRUE(r.round_off) << r.residual;
  EXPECT_EQ(r.stable, RelaxationResult::Stable::kYes);
  EXPECT_GT(r.residual, rules.tolerance);
  EXPECT_LT(r.residual, 1e-3);
  const double exact = 1e-7 / (3.0 * 21e6 * 0.2 * 1e-6 / 12.0);
  EXPECT_NEAR(displacement(m, s, {1.0, 0.1}).z(), exact, 0.01 * exact);  // 20 elements
}

// As after a load that has been taken off again: no force is left that a residual could be a share of.
TEST(Equilibrium, WithoutALoadIsRest) {
  Load none;
  none.kind = Load::Kind::kEdgeForce, none.edges = kUMax, none.force = Vec3::Zero();
  const ShellModel m = thin_strip(0.01, {clamp_at_the_root()}, none);
  ShellState s = make_state(m, Vec3::Zero(), 0);
  for (int i = 0; i < m.control_points(); ++i)
    if (!m.held[m.tables.slot(i)])
      s.motion.x[2 * m.tables.component_stride + m.tables.slot(i)] += 1e-3 * m.parameter[i].x();
  const RelaxationResult r = relax(m, s, {});
  ASSERT_TRUE(r.converged) << r.residual;
  EXPECT_EQ(r.stable, RelaxationResult::Stable::kYes);
  EXPECT_NEAR(displacement(m, s, {1.0, 0.1}).z(), 0.0, 1e-6);
}

// Elastica at P L^2/(E I) = 10: its end rises to 0.8106 of its length (Mattiasson 1981). The strip is so thin that
// one-sided differences give no useful tangent, and that all loads at once lead astray.
TEST(Equilibrium, OfAThinStripThatBendsFarIsFound) {
  const double thickness = 4e-3, stiffness = 21e6 * std::pow(thickness, 3) / 12.0;  // E h^3/12 [N m]
  Load load;
  load.kind = Load::Kind::kEdgeForce, load.edges = kUMax, load.force = Vec3(0, 0, 10.0 * stiffness);
  const ShellModel m = thin_strip(thickness, {clamp_at_the_root()}, load, 20);
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const RelaxationResult r = relax(m, s, {});
  ASSERT_TRUE(r.converged) << r.residual;
  EXPECT_EQ(r.share, 1.0);
  EXPECT_GT(r.load_steps, 0);
  EXPECT_EQ(r.stable, RelaxationResult::Stable::kYes);
  EXPECT_NEAR(displacement(m, s, {1.0, 0.1}).z(), 0.8106, 0.01);  // 20 elements
}

TEST(Equilibrium, OfAShellThatNothingHoldsIsNotFoundAndEnds) {
  Load load;
  load.kind = Load::Kind::kEdgeForce, load.edges = kUMax, load.force = Vec3(0, 0, 1.0);
  const ShellModel m = thin_strip(0.01, {}, load, 4);
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const RelaxationResult r = relax(m, s, {});
  EXPECT_FALSE(r.converged);
  EXPECT_STREQ(r.found_by(), "");
  EXPECT_EQ(r.share, 0.0);
  EXPECT_LT(r.steps, 100000);
}

// A rubber membrane holds no more than some pressure: beyond it grows without bound.
TEST(Equilibrium, AFailedSearchLeavesTheLastEquilibrium) {
  ShellMaterial rubber;
  rubber.density = 1000.0, rubber.youngs_modulus = 1e6, rubber.poisson_ratio = 0.45;
  Support frame;
  frame.edges = kUMin | kUMax | kVMin | kVMax, frame.clamped = false;
  Load load;
  load.kind = Load::Kind::kPressure, load.size = 1e5;
  const ShellModel m = make_shell("membrane", plate(1.0, 1.0, 4, 4, Vec3::Zero(), Quat::Identity()), 0.01, rubber, 2, 2,
                                  {frame}, {load});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const RelaxationResult r = relax(m, s, {});
  ASSERT_FALSE(r.converged);
  ASSERT_GT(r.share, 0.0);
  ASSERT_LT(r.share, 1.0);
  load.size *= r.share;
  const ShellModel shared = make_shell("membrane", m.patch, 0.01, rubber, 2, 2, {frame}, {load});
  compute_forces(shared, s, false, 0.0, 1);
  double left = 0.0, borne = 0.0;
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    (m.held[slot] ? borne : left) += s.at(s.motion.force, slot).squaredNorm();
  }
  EXPECT_LT(std::sqrt(left), 1e-3 * std::sqrt(borne));  // a step of the loads ends at 1e-4
  EXPECT_GT(displacement(m, s, {0.5, 0.5}).z(), 0.2);
  for (const double v : s.motion.v) EXPECT_EQ(v, 0.0);
}
