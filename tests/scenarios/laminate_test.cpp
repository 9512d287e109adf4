// Laminated glass: plies on an interlayer that goes on where they crack.
#include <gtest/gtest.h>

#include "shell/io/probes.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/parting/handoff.h"
#include "shell/solver/statics/relaxation.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kThickness = 0.006, kCore = 0.0015;

ShellMaterial laminated() {
  ShellMaterial m = glass();
  m.poisson_ratio = 0.0;
  m.interlayer = {kCore, 1100.0, 5e9, 0.0};
  return m;
}

Patch strip_patch() { return plate(0.3, 0.06, 30, 6, Vec3(0.15, 0.03, 0), Quat::Identity()); }

// The part of a plate of 0.3 m by 0.12 m from u = 0.0537 to 0.2463 m and v = 0.0213 to 0.0987 m, on no knot.
const Vec2 kLow(0.0537, 0.0213), kHigh(0.2463, 0.0987);

ShellModel trimmed_pane(const ShellMaterial& material, double thickness = kThickness) {
  const std::vector<Vec2> corners = {kLow, {kHigh.x(), kLow.y()}, kHigh, {kLow.x(), kHigh.y()}, kLow};
  return make_shell("pane", plate(0.3, 0.12, 30, 12, Vec3(0.15, 0.06, 0), Quat::Identity()), thickness, material, 2, 2,
                    {}, {}, TrimLoops(Vec2::Zero(), {0.3, 0.12}, {{corners, false}}));
}

// Moves all beyond the cut, and the same part of the core alone: both have the same energy.
void expect_energy_of_the_core(const ShellModel& m, ShellState& s, const ShellModel& core, double cut) {
  ShellState alone = make_state(core, Vec3::Zero(), 0);
  const Vec3 apart(1e-4, 2e-5, 3e-4);
  for (int i = 0; i < m.control_points(); ++i)
    for (int d = 0; d < 3; ++d)
      if (m.parameter[i].x() > cut) {
        const std::size_t k = d * static_cast<std::size_t>(m.tables.component_stride) + m.tables.slot(i);
        s.motion.x[k] += apart[d], alone.motion.x[k] += apart[d];
      }
  const double energy = compute_forces(m, s, true, 0.0, 1), expected = compute_forces(core, alone, true, 0.0, 1);
  ASSERT_GT(expected, 0.0);
  EXPECT_NEAR(energy, expected, 1e-9 * expected);  // glass that only moves has none, to the round-off of its stiffness
}

}  // namespace

TEST(Laminate, BendsAsBondedPliesDo) {
  Support clamp;
  clamp.edges = kUMin;
  Load moment;
  moment.kind = Load::Kind::kEdgeMoment, moment.edges = kUMax, moment.size = 1.0;
  const ShellMaterial material = laminated();
  const ShellModel m = make_shell("strip", strip_patch(), kThickness, material, 2, 2, {clamp}, {moment});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  RelaxationRules rules;
  rules.tolerance = 1e-9;
  ASSERT_TRUE(relax(m, s, rules).converged);
  const double core = std::pow(kCore, 3) / 12.0, all = std::pow(kThickness, 3) / 12.0;
  const double stiffness = material.youngs_modulus * (all - core) + material.interlayer.youngs_modulus * core;
  const double expected = moment.size * 0.3 * 0.3 / (2.0 * stiffness);
  // the clamped edge takes half a spacing's curvature: 1/30 of the length, squared
  EXPECT_NEAR(std::abs(displacement(m, s, {0.3, 0.03}).z()), expected, 2e-3 * expected);
}

TEST(Laminate, WeighsWhatPliesAndInterlayerWeigh) {
  const ShellModel m = make_shell("strip", strip_patch(), kThickness, laminated(), 2, 2, {});
  double mass = 0.0;
  for (const double part : m.mass) mass += part;
  EXPECT_NEAR(mass, 0.3 * 0.06 * (2500.0 * (kThickness - kCore) + 1100.0 * kCore), 1e-12);
}

TEST(Laminate, ForcesAreTheGradientBesideACut) {
  const ShellModel m = make_shell("patch", rational_patch(), 0.02, laminated(), 2, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  insert_polyline(m, s, {{0.1, 0.2}, {0.8, 0.7}}, 0.0);
  disturb(s, m, 1e-3);
  expect_gradient(m, s);
  const MomentumBalance b = balance(m, s);
  EXPECT_LT(b.force.norm(), 1e-12 * b.scale);
}

TEST(Laminate, HalvesThatPartFeelTheInterlayerAlone) {
  const ShellMaterial material = laminated();
  const ShellModel m = make_shell("strip", strip_patch(), kThickness, material, 2, 2, {});
  ShellMaterial soft = material;
  soft.interlayer = {};
  soft.youngs_modulus = material.interlayer.youngs_modulus;
  const ShellModel core = make_shell("core", strip_patch(), kCore, soft, 2, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const double cut = 0.1523;  // on no knot
  insert_polyline(m, s, {{cut, 0.0}, {cut, 0.06}}, 0.0);
  EXPECT_LT(compute_forces(m, s, true, 0.0, 1), 1e-20);
  expect_energy_of_the_core(m, s, core, cut);
}

TEST(Laminate, ThatIsTrimmedStretchesAsItsPliesAndItsInterlayer) {
  const ShellMaterial material = laminated();
  const ShellModel m = trimmed_pane(material);
  const double area = (kHigh - kLow).prod();
  double mass = 0.0;
  for (const double part : m.mass) mass += part;
  EXPECT_NEAR(mass, area * (2500.0 * (kThickness - kCore) + 1100.0 * kCore), 1e-9 * mass);
  ShellState s = make_state(m, Vec3::Zero(), 0);
  ASSERT_FALSE(s.cracked.of_interlayer.empty());
  EXPECT_LT(compute_forces(m, s, true, 0.0, 1), 1e-20);
  constexpr double kStretch = 1e-5;
  for (int i = 0; i < m.tables.component_stride; ++i) s.motion.x[i] *= 1.0 + kStretch;
  const double stiffness = material.youngs_modulus * (kThickness - kCore) + material.interlayer.youngs_modulus * kCore;
  const double expected = 0.5 * stiffness * kStretch * kStretch * area;
  // the strain, of the next order in the energy, times some tens of its third derivative
  EXPECT_NEAR(compute_forces(m, s, true, 0.0, 2), expected, 1e-4 * expected);
}

TEST(Laminate, ThatIsTrimmedHoldsCrackedPliesByItsInterlayerAlone) {
  const ShellMaterial material = laminated();
  const ShellModel m = trimmed_pane(material);
  ShellMaterial soft = material;
  soft.interlayer = {}, soft.youngs_modulus = material.interlayer.youngs_modulus;
  const ShellModel core = trimmed_pane(soft, kCore);
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const double cut = 0.1523;
  insert_polyline(m, s, {{cut, kLow.y()}, {cut, kHigh.y()}}, 0.0);
  EXPECT_LT(compute_forces(m, s, true, 0.0, 1), 1e-20);
  expect_energy_of_the_core(m, s, core, cut);
}

TEST(Laminate, ThatIsTrimmedHasForcesThatAreTheGradientOfItsEnergy) {
  const ShellModel m = trimmed_pane(laminated());
  ShellState s = make_state(m, Vec3::Zero(), 0);
  insert_polyline(m, s, {{0.1, 0.04}, {0.2, 0.07}}, 0.0);
  disturb(s, m, 1e-4);
  update_dropped_points(m.trim, s.motion.x);
  expect_gradient(m, s);
  const MomentumBalance b = balance(m, s);
  EXPECT_LT(b.force.norm(), 1e-12 * b.scale);
}

TEST(Laminate, ThatIsTrimmedLeavesNoForceBehind) {
  const ShellModel m = trimmed_pane(laminated());
  ShellState s = make_state(m, Vec3::Zero(), 0);
  std::vector<Piece> pieces;
  partition(m, s, pieces);
  ASSERT_FALSE(pieces.empty());
  for (const Piece& p : pieces) remove_piece(m, s, p);
  for (double& x : s.motion.x) x *= 1.01;
  EXPECT_EQ(compute_forces(m, s, true, 0.0, 1), 0.0);
}
