#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/mechanics/section.h"
#include "shell/solver/compression.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/state.h"
#include "shell/solver/stepping/kick_drift.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(InternalForce, OfEveryStressModelIsMinusTheGradientOfItsEnergy) {
  for (const StressModel model : {StressModel::kPaperProjection, StressModel::kJgt17, StressModel::kGhf18}) {
    ShellMaterial g = glass();
    g.stress_model = model;
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
      s.motion.x[2 * static_cast<std::size_t>(m->tables.plane) + m->tables.slot(i)] =
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

TEST(StressAtRest, IsAParabolaWithoutResultant) {
  for (const StressModel model :
       {StressModel::kPlaneStress, StressModel::kPaperProjection, StressModel::kJgt17, StressModel::kGhf18})
    for (const int count : {3, 5, 8}) {
      Elasticity e = elasticity(70e9, model == StressModel::kPlaneStress ? 0.22 : 0.45);
      e.model = model;
      Layers layers = gauss_layers(count, 0.004);
      prestress(layers, 0.004, 1e8, e);
      const Forms<double> flat{{0, 0, 1}, {1, 1, 0}, {0, 0, 0}, 1.0};
      const auto r = integrate_layers<double, false>(flat, {{1, 1, 0}, {0, 0, 0}}, layers, e);
      EXPECT_NEAR(r.n.c11, 0.0, 1e-10 * 1e8 * 0.004);
      EXPECT_NEAR(r.m.c22, 0.0, 1e-10 * 1e8 * 0.004 * 0.004);
      const Sym2<double> unit{1, 1, 0};
      for (std::size_t l = 0; l < layers.zeta.size(); ++l) {
        const double g = layers.growth[l], z = layers.zeta[l] / 0.002;
        EXPECT_NEAR(plane_stress<double>(unit, {g, g, 0}, e).s.c11, 0.5e8 * (1.0 - 3.0 * z * z), 1.0);  // 1 Pa of 1e8
      }
    }
}

// With Poisson's ratio -0.5 there is no plane stress below 0.446 of the area: mu (s - 1) + lambda/2 ln s = -lambda ln
// J.
TEST(PlaneStress, OfAuxeticsHasAnAnswerDownToTheLeastArea) {
  Elasticity e = elasticity(1e9, -0.5);
  const double least = e.least_log_area = find_least_log_area(e);
  EXPECT_NEAR(std::exp(least), 0.4463, 1e-4);
  for (const double log_area : {0.9 * least, 0.5 * least, -0.01, 0.3, 1.0}) {
    const double root = std::exp(log_area);
    const PlaneStress<double> p = plane_stress<double>({root, root, 0}, {1, 1, 0}, e);
    EXPECT_NEAR(e.mu * (p.stretch2 - 1.0) + 0.5 * e.lambda * std::log(p.stretch2) + e.lambda * log_area, 0.0,
                1e-9 * e.mu)
        << log_area;
  }
  EXPECT_TRUE(std::isinf(find_least_log_area(elasticity(1e9, 0.3))));
}

TEST(Compression, PastWhatANegativePoissonRatioPermitsIsRefusedWithTheNumber) {
  ShellMaterial g = glass();
  g.poisson_ratio = -0.5;
  const ShellModel m = make_shell("p", plate(0.5, 0.4, 6, 5, Vec3::Zero(), Quat::Identity()), 0.004, g, 2, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const auto squeeze = [&](double share) {
    for (int i = 0; i < m.control_points(); ++i) s.motion.x[m.tables.slot(i)] = share * m.patch.control_points[i].x();
  };
  squeeze(0.5);
  check_compression(m, s);
  squeeze(0.44);
  compute_forces(m, s, false, 0.0, 1);
  for (const double f : s.motion.force) EXPECT_TRUE(std::isfinite(f));
  try {
    check_compression(m, s);
    FAIL() << "not refused";
  } catch (const Error& e) {
    EXPECT_EQ(e.status, Exit::kPhysics);
    EXPECT_NE(std::string(e.what()).find("0.44 of its area"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("0.446"), std::string::npos) << e.what();
  }
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
      for (int d = 0; d < 3; ++d) s.motion.x[d * static_cast<std::size_t>(m.tables.plane) + m.tables.slot(i)] = x[d];
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

TEST(StableStep, OfAPlateIsThatOfItsStiffestMembraneMode) {
  const Support all{kUMin | kUMax | kVMin | kVMax, true};
  const ShellModel m =
      make_shell("p", plate(0.5, 0.5, 40, 40, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {all});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  // quadratic B-splines with lumped mass: omega^2 = 3/2 (c/h)^2 for an endless row, so 1.633 h/c
  EXPECT_NEAR(stable_step(m, s, 200, 1, false) * m.wave_speed() / m.spacing, 1.633, 0.02);
  EXPECT_NEAR(stable_step(m, s, 200, 1, true) * m.wave_speed() / m.spacing, 0.82, 0.03);
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

TEST(Damping, LetsAModeDecayAtItsRate) {
  ShellMaterial material = glass();
  material.mass_damping = 400.0, material.stiffness_damping = 2e-6;
  const Support all{kUMin | kUMax | kVMin | kVMax, false};
  const ShellModel m =
      make_shell("p", plate(0.2, 0.2, 12, 12, Vec3::Zero(), Quat::Identity()), 0.004, material, 2, 2, {all});
  ShellState s = make_state(m, Vec3::Zero(), 1);
  // first bending mode of a simply supported square, small: linear
  for (int i = 0; i < m.control_points(); ++i)
    if (!m.held[m.tables.slot(i)])
      s.motion.v[2 * static_cast<std::size_t>(m.tables.plane) + m.tables.slot(i)] =
          0.1 * std::sin(M_PI * m.parameter[i].x() / 0.2) * std::sin(M_PI * m.parameter[i].y() / 0.2);
  const double rigidity = 70e9 * std::pow(0.004, 3) / (12 * (1 - 0.22 * 0.22));
  const double omega = 2 * std::pow(M_PI / 0.2, 2) * std::sqrt(rigidity / (2500 * 0.004));
  const double dt = 0.5 * stable_step(m, s, 100, 1, false), end = 10 * 2 * M_PI / omega;
  double energy = 0.0, first = -1.0;
  for (double time = 0.0; time < end; time += dt) {
    energy = compute_forces(m, s, true, 0.0, 1) + kinetic_energy(m, s, dt);
    if (first < 0.0) first = energy;
    const double before = energy + s.book.damping;
    kick(m, s, Vec3::Zero(), dt), drift(m, s, dt);
    compute_forces(m, s, false, 0.0, 1);
    ASSERT_LE(std::abs(before - first), 1e-5 * first);  // booked, but for 1e-10 J of round-off
  }
  // energy goes as exp(-(alpha + beta omega^2) t); omega of the grid is within 1 % of the plate's
  const double rate = 400.0 + 2e-6 * omega * omega;
  EXPECT_NEAR(std::log(first / energy), rate * end, 0.03 * rate * end);
}
