// Modes of vibration against exact and published frequencies.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/geometry/builders.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/statics/modes.h"
#include "shell/solver/statics/relaxation.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kPi = std::numbers::pi;

ModeSet modes_of(const ShellModel& m, ShellState& s, int count) {
  return vibration_modes(m, s, count, [&] { compute_forces(m, s, false, 0.0, 1); });
}
ModeSet modes_of(const ShellModel& m, int count) {
  ShellState s = make_state(m, Vec3::Zero(), 0);
  return modes_of(m, s, count);
}

double omega2(const Mode& mode) { return std::pow(2.0 * kPi * mode.frequency, 2); }

/// omega a^2 sqrt(rho h / D) of a square plate, a = 1 m.
double plate_number(const ShellModel& m, const Mode& mode) {
  const ShellMaterial& q = m.material;
  const double d = q.youngs_modulus * std::pow(m.thickness, 3) / (12.0 * (1.0 - q.poisson_ratio * q.poisson_ratio));
  return 2.0 * kPi * mode.frequency * std::sqrt(q.density * m.thickness / d);
}

ShellModel square(const std::vector<Support>& supports, int elements) {
  ShellMaterial q = glass();
  q.poisson_ratio = 0.3;
  return make_shell("plate", plate(1, 1, elements, elements, Vec3::Zero(), Quat::Identity(), 3), 0.005, q, 2, 3,
                    supports);
}

Support edges(int which, bool clamped) {
  Support s;
  s.edges = which, s.clamped = clamped;
  return s;
}

constexpr int kAll = kUMin | kUMax | kVMin | kVMax;

/// A strip of 1 m x 0.2 m x 1 cm that bends as a beam.
ShellModel cubic_strip(const std::vector<Support>& supports, const std::vector<Load>& loads) {
  ShellMaterial q = glass();
  q.poisson_ratio = 0.0;
  return make_shell("strip", plate(1, 0.2, 20, 4, Vec3(0.5, 0.1, 0), Quat::Identity(), 3), 0.01, q, 2, 3, supports,
                    loads);
}
/// Pinned at x = 0, on a roller at x = 1 m, pulled there [N].
ShellModel pulled_strip(double pull) {
  Support roller = edges(kUMax, false);
  roller.axes = {false, true, true};
  Load load;
  load.kind = Load::Kind::kEdgeForce, load.edges = kUMax, load.force = Vec3(pull / 0.2, 0, 0);
  return cubic_strip({edges(kUMin, false), roller}, {load});
}
// Of the n-th mode of a pinned beam under tension: omega^2 = (n pi / L)^4 EI / rho A + (n pi / L)^2 T / rho A.
double beam(int n, double pull) {
  const double k = n * kPi, area = 0.2 * 0.01, stiffness = 70e9 * 0.2 * 1e-6 / 12.0;
  return (std::pow(k, 4) * stiffness + k * k * pull) / (2500.0 * area);
}

}  // namespace

TEST(Modes, OfAClampedSquarePlateAreThePublishedOnes) {
  const ShellModel m = square({edges(kAll, true)}, 24);
  const ModeSet found = modes_of(m, 6);
  ASSERT_EQ(found.modes.size(), 6u);
  EXPECT_EQ(found.rigid, 0);
  EXPECT_EQ(found.unstable, 0);
  const double leissa[] = {35.992, 73.413, 73.413, 108.27, 131.64, 132.24};
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(plate_number(m, found.modes[k]), leissa[k], 1e-3 * leissa[k]) << k;
}

TEST(Modes, OfASimplySupportedSquarePlateAreMultiplesOfPiSquared) {
  const ShellModel m = square({edges(kAll, false)}, 24);
  const ModeSet found = modes_of(m, 6);
  const double multiple[] = {2, 5, 5, 8, 10, 10};
  for (int k = 0; k < 6; ++k)
    EXPECT_NEAR(plate_number(m, found.modes[k]), multiple[k] * kPi * kPi, 1e-3 * multiple[k] * kPi * kPi) << k;
}

// Free-free beam: beta L = 4.730041, 7.853205.
TEST(Modes, OfAFreeStripLeaveOutSixRigidMotions) {
  const ShellModel m = cubic_strip({}, {});
  const ModeSet found = modes_of(m, 6);
  EXPECT_EQ(found.rigid, 6);
  EXPECT_EQ(found.unstable, 0);
  const double unit = 70e9 * 1e-4 / 12.0 / 2500.0;
  EXPECT_NEAR(omega2(found.modes[0]) / (std::pow(4.730041, 4) * unit), 1.0, 1e-3);
  EXPECT_GT(found.modes[0].frequency, 10.0);
}

TEST(Modes, OfAPulledStripAreThoseOfABeamUnderTension) {
  for (const double pull : {0.0, 4e3, -0.5 * beam(1, 0.0) * 5.0 / (kPi * kPi)}) {
    const ShellModel m = pulled_strip(pull);
    ShellState s = make_state(m, Vec3::Zero(), 0);
    RelaxationRules rules;
    rules.tolerance = 1e-10;
    if (pull != 0.0) {
      ASSERT_TRUE(relax(m, s, rules).converged);
    }
    const ModeSet found = modes_of(m, s, 2);
    EXPECT_NEAR(omega2(found.modes[0]) / beam(1, pull), 1.0, 1e-3) << pull;
    EXPECT_NEAR(omega2(found.modes[1]) / beam(2, pull), 1.0, 1e-3) << pull;
  }
}

TEST(Modes, BeyondEulersLoadOneIsUnstable) {
  const double euler = beam(1, 0.0) * 5.0 / (kPi * kPi);  // rho A = 5 kg/m
  const ShellModel m = pulled_strip(-1.5 * euler);
  ShellState s = make_state(m, Vec3::Zero(), 0);
  RelaxationRules rules;
  rules.tolerance = 1e-10;
  ASSERT_TRUE(relax(m, s, rules).converged);  // straight, as nothing bends it
  const ModeSet found = modes_of(m, s, 2);
  EXPECT_EQ(found.unstable, 1);
  EXPECT_NEAR(found.modes[0].eigenvalue / beam(1, -1.5 * euler), 1.0, 1e-2);  // lumped: (pi/20)^2 / 3 = 0.8 %
  EXPECT_EQ(found.modes[0].frequency, 0.0);
  EXPECT_GT(found.modes[1].frequency, 0.0);
}

// A quarter of a ring, on two planes of symmetry: omega^2 = n^2 (n^2 - 1)^2 / (n^2 + 1) EI / (rho A R^4) for even n. It
// may move along its axis.
TEST(Modes, OfAFreeRingAreThoseOfHoppe) {
  constexpr double kRadius = 0.5, kThickness = 0.005;
  Support x = edges(kUMin, false), y = edges(kUMax, false);
  x.symmetry = 1, y.symmetry = 0;
  ShellMaterial q = glass();
  q.poisson_ratio = 0.0;
  const ShellModel m = make_shell("ring",
                                  placed(cylinder(kRadius, 0.05, 0.5 * kPi, 32, 3, 3), Vec3::Zero(),
                                         Quat(Eigen::AngleAxisd(0.25 * kPi, Vec3::UnitZ()))),
                                  kThickness, q, 2, 3, {x, y});
  const ModeSet found = modes_of(m, 10);
  EXPECT_EQ(found.rigid, 1);
  const double unit = q.youngs_modulus * kThickness * kThickness / 12.0 / q.density / std::pow(kRadius, 4);
  int n = 2;
  for (const Mode& mode : found.modes) {
    double along = 0.0;  // of the axis
    for (int i = 0; i < m.control_points(); ++i)
      along = std::max(along, std::abs(mode.shape[2 * m.tables.component_stride + m.tables.slot(i)]));
    if (along > 0.01) continue;
    const double exact = unit * n * n * std::pow(n * n - 1, 2) / (n * n + 1);
    EXPECT_NEAR(omega2(mode) / exact, 1.0, 5e-3) << n;
    n += 2;
  }
  EXPECT_GE(n, 6);
}

TEST(Modes, ShapesHaveTheLargestLengthOneAndAreOrthogonal) {
  const ShellModel m = square({edges(kUMin, true)}, 8);
  const ModeSet found = modes_of(m, 4);
  for (std::size_t i = 0; i < 4; ++i) {
    double largest = 0.0;
    for (int k = 0; k < m.control_points(); ++k) {
      const std::size_t slot = m.tables.slot(k), stride = m.tables.component_stride;
      const auto& u = found.modes[i].shape;
      largest = std::max(largest, Vec3(u[slot], u[stride + slot], u[2 * stride + slot]).norm());
    }
    EXPECT_NEAR(largest, 1.0, 1e-12);
    for (std::size_t j = 0; j < i; ++j) {
      double product = 0.0, own = 0.0;
      for (std::size_t k = 0; k < found.modes[i].shape.size(); ++k) {
        const double mass = m.mass[k % m.tables.component_stride];
        product += mass * found.modes[i].shape[k] * found.modes[j].shape[k];
        own += mass * found.modes[i].shape[k] * found.modes[i].shape[k];
      }
      EXPECT_LT(std::abs(product), 1e-8 * own);
    }
  }
}

TEST(Modes, AreRefusedForCracksAndForMoreThanThereAre) {
  ShellMaterial q = glass();
  const ShellModel m =
      make_shell("p", plate(1, 1, 2, 2, Vec3::Zero(), Quat::Identity()), 0.01, q, 2, 2, {edges(kAll, false)});
  EXPECT_THROW(modes_of(m, 1000), Error);
  const ShellModel sheet = brittle_sheet(8);
  ShellState s = make_state(sheet, Vec3::Zero(), 0);
  insert_polyline(sheet, s, {Vec2(0.05, 0.1), Vec2(0.15, 0.1)}, 0.0);
  EXPECT_THROW(modes_of(sheet, s, 2), Error);
}
