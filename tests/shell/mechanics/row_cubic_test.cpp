// Patches of degree 3. What holds for any degree is tested on quadratic patches in the other files.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "shell/io/probes.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/parting/handoff.h"
#include "shell/solver/statics/relaxation.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

Patch cubic_plate(int across, int along) { return plate(0.5, 0.4, across, along, Vec3::Zero(), Quat::Identity(), 3); }

double largest_force(const ShellState& s) {
  double largest = 0.0;
  for (const double f : s.motion.force) largest = std::max(largest, std::abs(f));
  return largest;
}

}  // namespace

TEST(CubicShell, WeighsWhatItIsAndHasPositiveMasses) {
  const ShellModel m = make_shell("p", cubic_plate(7, 5), 0.004, glass(), 2, 3, {});
  double sum = 0.0;
  for (int i = 0; i < m.control_points(); ++i) {
    EXPECT_GT(m.mass[m.tables.slot(i)], 0.0);
    sum += m.mass[m.tables.slot(i)];
  }
  EXPECT_NEAR(sum, 2500 * 0.004 * 0.5 * 0.4, 1e-13);
}

TEST(CubicShell, ForceIsMinusTheGradientOfEnergy) {
  const ShellModel flat = make_shell("p", cubic_plate(7, 5), 0.004, glass(), 3, 3, {});
  const ShellModel curved = make_shell("p", cubic_patch(), 0.02, glass(), 3, 4, {});
  const ShellModel cut = make_shell("p", cubic_plate(12, 10), 0.004, glass(), 2, 3, {});
  ShellState a = make_state(flat, Vec3::Zero(), 0), b = make_state(curved, Vec3::Zero(), 0),
             c = make_state(cut, Vec3::Zero(), 0);
  insert_polyline(cut, c, {{0.0, 0.11}, {0.31, 0.27}}, 0.0);
  ASSERT_GT(c.cracked.gathered.size(), 10u);
  disturb(a, flat, 2e-3), disturb(b, curved, 5e-3), disturb(c, cut, 1e-3);
  expect_gradient(flat, a);
  expect_gradient(curved, b);
  expect_gradient(cut, c);
}

// The rows' forces are those of the same points gathered: another kernel, with functions of its own making.
TEST(CubicShell, RowsAndGatheredPointsAgree) {
  for (const bool rational : {false, true}) {
    const Patch p = rational ? cubic_patch() : cubic_plate(13, 9);
    const ShellModel m = make_shell("p", p, 0.01, glass(), 2, 3, {});
    ShellState rows = make_state(m, Vec3::Zero(), 0);
    disturb(rows, m, 2e-3);
    ShellState points = rows;
    for (int q = 0; q < m.tables.blocks(); ++q)
      for (int e = 0; e < m.tables.spans_u; ++e) gather_point(m, points, q, e);
    const double a = compute_forces(m, rows, true, 1.0, 1), b = compute_forces(m, points, true, 1.0, 1);
    EXPECT_NEAR(a, b, 1e-12 * a);
    const double scale = largest_force(rows);
    for (std::size_t i = 0; i < rows.motion.force.size(); ++i)
      EXPECT_NEAR(rows.motion.force[i], points.motion.force[i], 1e-11 * scale);
  }
}

TEST(CubicShell, FeelsNoForceAtRestAndUnderRigidMotionCracksIncluded) {
  for (const bool rational : {false, true}) {
    const ShellModel m = make_shell("p", rational ? cubic_patch() : cubic_plate(12, 10), 0.004, glass(), 2, 3, {});
    for (const bool cut : {false, true}) {
      ShellState s = make_state(m, Vec3::Zero(), 0);
      const Vec2 end(m.patch.knots_u.end(), m.patch.knots_v.end());
      if (cut) insert_polyline(m, s, {{0.0, 0.31 * end.y()}, {0.6 * end.x(), 0.62 * end.y()}}, 0.0);
      EXPECT_EQ(s.cracked.gathered.empty(), !cut);
      // a strain of 1e-12 times the membrane stiffness over an element
      const double limit = 1e-12 * 70e9 * 0.004 * m.spacing * 30.0;
      compute_forces(m, s, false, 0.0, 1);
      EXPECT_LT(largest_force(s), limit);
      const Quat q = rotation_from_vector(Vec3(0.3, -0.7, 0.5));
      for (int i = 0; i < m.control_points(); ++i) {
        const Vec3 x = q * s.position(m.tables.slot(i)) + Vec3(1, 2, 3);
        for (int d = 0; d < 3; ++d)
          s.motion.x[d * static_cast<std::size_t>(m.tables.component_stride) + m.tables.slot(i)] = x[d];
      }
      compute_forces(m, s, false, 0.0, 1);
      EXPECT_LT(largest_force(s), limit);
    }
  }
}

TEST(CubicShell, BalancesForceAndTorqueBesideACut) {
  for (const Patch& p : {cubic_plate(12, 10), cubic_patch()})
    expect_balance_beside_a_cut(make_shell("p", p, 0.01, glass(), 2, 3, {}), {0.0, 0.13}, {0.3, 0.21});
}

TEST(CubicShell, KeepsMomentumAngularMomentumAndEnergyInFlight) {
  Rig rig(setup_of({{make_shell("p", cubic_plate(6, 5), 0.004, glass(), 2, 3, {}), Vec3(1.0, -2.0, 0.5)}}));
  const ShellModel& m = rig.model();
  ShellState& s = rig.state();
  for (int i = 0; i < m.control_points(); ++i) {
    const Vec3 x = s.position(m.tables.slot(i));
    s.add_velocity(m.tables.slot(i), Vec3(0.3, 0.2, 2.0).cross(x) + Vec3(0, 0, 0.2 * std::cos(12.0 * x.x())));
  }
  const double dt = 0.8 * stable_step(m, s, 150, 1, false);
  rig.step(dt);
  const Totals before = totals(m, s);
  const double energy = compute_forces(m, s, true, 0.0, 1) + kinetic_energy(m, s, dt);
  rig.run(2000, dt);
  const Totals after = totals(m, s);
  // sums of 2000 steps, one part in 1e16 each
  EXPECT_LT((after.momentum - before.momentum).norm(), 1e-12 * before.momentum_scale);
  EXPECT_LT((after.angular - before.angular).norm(), 1e-12 * before.angular_scale);
  // leapfrog's energy of a nonlinear shell swings by the share of the strain, a part in a thousand at most
  EXPECT_NEAR(compute_forces(m, s, true, 0.0, 1) + kinetic_energy(m, s, dt), energy, 1e-3 * energy);
}

TEST(CubicShell, IsTheSameForAnyNumberOfThreads) {
  const ShellModel m = make_shell("p", cubic_plate(30, 21), 0.004, glass(), 2, 3, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  insert_polyline(m, s, {{0.0, 0.11}, {0.31, 0.27}}, 0.0);
  disturb(s, m, 1e-3);
  compute_forces(m, s, false, 0.0, 1);
  const std::vector<double> one = s.motion.force;
  compute_forces(m, s, false, 0.0, 3);
  EXPECT_EQ(one, s.motion.force);
}

TEST(CubicShell, HalvesApartFeelNoForceAndAreTwoPieces) {
  const ShellModel m = make_shell("p", cubic_plate(20, 16), 0.004, glass(), 2, 3, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  insert_polyline(m, s, {{0.231, 0.0}, {0.268, 0.4}}, 0.0);  // through no control point
  std::vector<Piece> pieces;
  EXPECT_EQ(partition(m, s, pieces).pieces, 2);
  for (int i = 0; i < m.control_points(); ++i)
    if (orientation({0.231, 0.0}, {0.268, 0.4}, m.parameter[i]) < 0.0) s.motion.x[m.tables.slot(i)] += 0.01;
  compute_forces(m, s, false, 0.0, 1);
  EXPECT_LT(largest_force(s), 1e-12 * 70e9 * 0.004 * m.spacing * 30.0);
}

TEST(CubicShell, ACutAlongKnotsPutsEachControlPointOnOneSide) {
  const ShellModel m =
      make_shell("p", plate(0.3, 0.3, 24, 24, Vec3::Zero(), Quat::Identity(), 3), 0.004, glass(), 2, 3, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  // knots, and with them control points, stand every 0.0125
  insert_polyline(m, s, {{0.1, 0.1}, {0.2, 0.1}, {0.2, 0.2}, {0.1, 0.2}, {0.1, 0.1}}, 0.0);
  std::vector<Piece> pieces;
  const Triangulation t = partition(m, s, pieces);
  ASSERT_EQ(t.pieces, 2);
  const int inner = pieces[0].area < pieces[1].area ? 0 : 1;
  EXPECT_NEAR(pieces[inner].area, 0.01, 1e-12);
  for (int i = 0; i < m.control_points(); ++i)
    if (t.owner[i] == inner) s.motion.x[m.tables.slot(i)] += 0.01;
  compute_forces(m, s, false, 0.0, 1);
  EXPECT_LT(largest_force(s), 1e-12 * 70e9 * 0.004 * m.spacing * 30.0);
}

TEST(CubicShell, NewtonFindsTheCantileverOfBeamTheory) {
  Support clamp;
  clamp.edges = kUMin;
  Load tip;
  tip.kind = Load::Kind::kEdgeForce, tip.edges = kUMax, tip.force = Vec3(0, 0, 1.0);
  ShellMaterial g = glass();
  g.poisson_ratio = 0.0;
  const ShellModel m =
      make_shell("strip", plate(1.0, 0.2, 8, 2, Vec3(0.5, 0.1, 0), Quat::Identity(), 3), 0.01, g, 2, 3, {clamp}, {tip});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  RelaxationRules rules;
  rules.tolerance = 1e-7;
  const RelaxationResult r = relax(m, s, rules);
  EXPECT_TRUE(r.converged);
  EXPECT_EQ(r.steps, 0);  // Newton did it: every control point's reach is in the tangent
  EXPECT_LE(r.newton, 6);
  // F l^3 / (3 E I) is a cubic, which the patch holds exactly; the rest is round-off of differences
  const double exact = 1.0 / (3.0 * 70e9 * std::pow(0.01, 3) / 12.0);
  EXPECT_NEAR(displacement(m, s, {1.0, 0.1}).z() / exact, 1.0, 1e-7);
}
