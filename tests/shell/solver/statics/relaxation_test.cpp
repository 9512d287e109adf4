// Equilibrium, by Newton and by relaxation.
#include <gtest/gtest.h>

#include "shell/io/probes.h"
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
