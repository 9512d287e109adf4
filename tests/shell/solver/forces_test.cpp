#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/state.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(InternalForce, OfEveryStressModelIsMinusTheGradientOfItsEnergy) {
  for (int k = 0; k < kElasticLaws; ++k) {
    ShellMaterial g = glass();
    g.stress_model = StressModel{k};
    const ShellModel m = make_shell("p", rational_patch(), 0.05, g, 3, 3, {});
    for (const double size : {1e-3, 0.03}) {  // both branches of the logarithm
      ShellState s = make_state(m, Vec3::Zero(), 0);
      disturb(s, m, size);
      expect_gradient(m, s);
    }
  }
}

TEST(InternalForce, OfLinearBendingAndOfStressAtRestIsMinusTheGradientOfItsEnergy) {
  ShellMaterial linear = glass(), tempered = glass();
  linear.linear_bending = true, tempered.surface_compression = 1e8;
  for (const ShellMaterial& g : {linear, tempered}) {
    const ShellModel m = make_shell("p", rational_patch(), 0.02, g, 5, 3, {});
    ShellState s = make_state(m, Vec3::Zero(), 0);
    insert_polyline(m, s, {{0.0, 0.4}, {0.5, 0.5}}, 0.0);
    disturb(s, m, 1e-3);
    expect_gradient(m, s);
  }
}

// Linear bending is what many layers come to where a plate bends a little.
TEST(InternalForce, OfLinearBendingIsThatOfLayers) {
  ShellMaterial g = glass();
  const Patch patch = plate(0.5, 0.4, 7, 5, Vec3::Zero(), Quat::Identity());
  const ShellModel layered = make_shell("p", patch, 0.01, g, 4, 3, {});
  g.linear_bending = true;
  const ShellModel linear = make_shell("p", patch, 0.01, g, 4, 3, {});
  std::vector<double> forces[2];
  double energy[2];
  for (const ShellModel* m : {&layered, &linear}) {
    ShellState s = make_state(*m, Vec3::Zero(), 0);
    for (int i = 0; i < m->control_points(); ++i)
      s.motion.x[2 * static_cast<std::size_t>(m->tables.component_stride) + m->tables.slot(i)] =
          3e-5 * std::sin(9.0 * m->parameter[i].x()) * std::cos(7.0 * m->parameter[i].y());
    energy[m == &linear] = compute_forces(*m, s, true, 0.0, 1);
    forces[m == &linear] = s.motion.force;
  }
  EXPECT_NEAR(energy[0] / energy[1], 1.0, 1e-4);  // stretching takes (w'^2 / t w'')^2 = 1e-5
  double scale = 0.0;
  for (const double f : forces[0]) scale = std::max(scale, std::abs(f));
  for (std::size_t i = 2 * forces[0].size() / 3; i < forces[0].size(); ++i)  // across the plate
    EXPECT_NEAR(forces[0][i], forces[1][i], 1e-4 * scale);
}

TEST(InternalForce, IsMinusTheGradientOfEnergyOnAPlate) {
  const ShellModel m = make_shell("p", plate(0.5, 0.4, 7, 5, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 3, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  disturb(s, m, 2e-3);
  expect_gradient(m, s);
}

TEST(InternalForce, IsMinusTheGradientOfEnergyOnARationalPatch) {
  const ShellModel m = make_shell("p", rational_patch(), 0.02, glass(), 3, 3, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  disturb(s, m, 5e-3);
  expect_gradient(m, s);
}

TEST(InternalForce, IsMinusTheGradientOfEnergyBesideACut) {
  const ShellModel m =
      make_shell("p", plate(0.5, 0.4, 12, 10, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  insert_polyline(m, s, {{0.0, 0.11}, {0.31, 0.27}}, 0.0);
  ASSERT_GT(s.cracked.gathered.size(), 10u);
  disturb(s, m, 1e-3);
  expect_gradient(m, s);
}

TEST(InternalForce, VanishesAtRestAndUnderRigidMotionCracksIncluded) {
  for (const bool rational : {false, true}) {
    const Patch p = rational ? rational_patch() : plate(0.5, 0.4, 12, 10, Vec3::Zero(), Quat::Identity());
    const ShellModel m = make_shell("p", p, 0.004, glass(), 2, 2, {});
    ShellState s = make_state(m, Vec3::Zero(), 0);
    const Vec2 end(m.patch.knots_u.end(), m.patch.knots_v.end());
    insert_polyline(m, s, {{0.0, 0.31 * end.y()}, {0.6 * end.x(), 0.62 * end.y()}}, 0.0);
    const Quat q = rotation_from_vector(Vec3(0.3, -0.7, 0.5));
    for (int i = 0; i < m.control_points(); ++i) {
      const Vec3 x = q * s.position(m.tables.slot(i)) + Vec3(1, 2, 3);
      for (int d = 0; d < 3; ++d)
        s.motion.x[d * static_cast<std::size_t>(m.tables.component_stride) + m.tables.slot(i)] = x[d];
    }
    compute_forces(m, s, false, 0.0, 1);
    double largest = 0.0;
    for (const double f : s.motion.force) largest = std::max(largest, std::abs(f));
    // a strain of 1e-12 times the membrane stiffness over an element
    EXPECT_LT(largest, 1e-12 * 70e9 * 0.004 * m.spacing * 30.0);
  }
}

TEST(InternalForce, BalancesForceAndTorqueBesideACut) {
  expect_balance_beside_a_cut(make_shell("p", rational_patch(), 0.01, glass(), 2, 3, {}), {0.0, 0.3}, {0.5, 0.5});
}

TEST(InternalForce, IsTheSameForAnyNumberOfThreads) {
  const ShellModel m =
      make_shell("p", plate(0.5, 0.4, 30, 21, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  insert_polyline(m, s, {{0.0, 0.11}, {0.31, 0.27}}, 0.0);
  disturb(s, m, 1e-3);
  compute_forces(m, s, false, 0.0, 1);
  const std::vector<double> one = s.motion.force;
  compute_forces(m, s, false, 0.0, 3);
  EXPECT_EQ(one, s.motion.force);
}

TEST(InternalForce, DoesNotDependOnTheShellBefore) {
  // rows of 6 and of 13 elements are padded alike on some machines
  const ShellModel wide =
      make_shell("w", plate(0.5, 0.4, 13, 5, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {});
  const ShellModel m = make_shell("p", plate(0.5, 0.4, 6, 5, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {});
  ShellState before = make_state(wide, Vec3::Zero(), 0), s = make_state(m, Vec3::Zero(), 0);
  disturb(before, wide, 1e-3), disturb(s, m, 1e-3);
  compute_forces(m, s, false, 0.0, 1);
  const std::vector<double> alone = s.motion.force;
  compute_forces(wide, before, false, 0.0, 1);
  compute_forces(m, s, false, 0.0, 1);
  EXPECT_EQ(alone, s.motion.force);
}

TEST(ReleasedHalves, FeelNoForce) {
  const ShellModel m =
      make_shell("p", plate(0.5, 0.4, 20, 16, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  insert_polyline(m, s, {{0.23, 0.0}, {0.27, 0.4}}, 0.0);
  for (int i = 0; i < m.control_points(); ++i) {
    const Vec2 p = m.parameter[i];
    if (orientation({0.23, 0.0}, {0.27, 0.4}, p) < 0.0) s.motion.x[m.tables.slot(i)] += 0.01;
  }
  compute_forces(m, s, false, 0.0, 1);
  double largest = 0.0;
  for (const double f : s.motion.force) largest = std::max(largest, std::abs(f));
  EXPECT_LT(largest, 1e-12 * 70e9 * 0.004 * m.spacing * 30.0);
}
