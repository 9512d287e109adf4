// Which way a tip goes on in a field that is the same everywhere.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "shell/mechanics/principal.h"
#include "shell/solver/cracking/tip_drive.h"
#include "shell/solver/forces.h"
#include "shell/solver/surroundings.h"
#include "tests/shell/critical_sheet.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

// What drives a tip at `angle` that may turn by `most`, in a sheet pulled by 1 MPa across `across`; of that on
// the lower face the share `lower`: 1 stretched, -1 bent.
Drive drive_of(double angle, double across, double lower, double most) {
  ShellMaterial material = glass();
  material.strength = 60e6, material.fracture_energy = 8.0;
  const ShellModel m =
      make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity()), 0.004, material, 2, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 1);
  compute_forces(m, s, false, 1.0, 1);
  const Vec2 pull = turned(Vec2(0, 1), across);
  const double upper[3] = {1e6 * pull.x() * pull.x(), 1e6 * pull.y() * pull.y(), 1e6 * pull.x() * pull.y()};
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int lane = 0; lane < m.tables.spans_u; ++lane)
      for (int k = 0; k < 3; ++k) {
        s.layers.face_stress[m.tables.at(q, 6, k, lane)] = lower * upper[k];
        s.layers.face_stress[m.tables.at(q, 6, 3 + k, lane)] = upper[k];
      }
  Start start;
  start.p = {0.1033, 0.0971}, start.direction = turned(Vec2(1, 0), angle), start.most_turn = most;
  return drive_at(m, s, make_crack_rules(m, 0.0), start);
}

double turn_of(double angle, double across, double lower, double most) {
  return drive_of(angle, across, lower, most).turn;
}

}  // namespace

TEST(TipDrive, TakesOffWhatTheLatticeTurnsABentCrackBy) {
  for (const double degrees : {0.0, 22.5, 45.0, 67.5, 90.0, -22.5, 157.5}) {
    const double angle = degrees * kDegree, off = -3.7 * kDegree * std::sin(4.0 * angle);
    EXPECT_NEAR(turn_of(angle, angle, -1.0, 80.0 * kDegree), off, 0.01 * kDegree) << degrees;
    EXPECT_NEAR(turn_of(angle, angle, 1.0, 80.0 * kDegree), 0.0, 0.01 * kDegree) << degrees;
  }
  const double half = turn_of(22.5 * kDegree, 22.5 * kDegree, 0.0, 80.0 * kDegree);  // one face pulled
  EXPECT_LT(half, -0.5 * kDegree);
  EXPECT_GT(half, -3.2 * kDegree);
}

TEST(TipDrive, TurnsNoFurtherThanItMayAndOnlyThenByThat) {
  const double angle = 22.5 * kDegree, most = 10.0 * kDegree;
  // the field is 12 degrees on, of which 3.7 are the lattice's
  EXPECT_NEAR(turn_of(angle, angle + 12.0 * kDegree, -1.0, most), 8.3 * kDegree, 0.1 * kDegree);
  EXPECT_NEAR(turn_of(angle, angle + 30.0 * kDegree, -1.0, most), most, 1e-12);
  EXPECT_NEAR(turn_of(angle, angle - 30.0 * kDegree, -1.0, most), -most, 1e-12);
  EXPECT_EQ(turn_of(angle, angle, -1.0, 0.0), 0.0);
  // and is driven by what it finds there: stress across a direction goes with the squared cosine
  const double whole = drive_of(angle, angle, 1.0, most).ratio, bent = drive_of(angle, angle, -1.0, most).ratio;
  for (const double sign : {-1.0, 1.0}) {
    EXPECT_NEAR(drive_of(angle, angle + sign * 30.0 * kDegree, 1.0, most).ratio,
                whole * std::pow(std::cos(20.0 * kDegree), 2), 1e-6 * whole);
    const double away = 30.0 * kDegree - sign * 3.7 * kDegree - most;  // of the direction as the lattice shows it
    EXPECT_NEAR(drive_of(angle, angle + sign * 30.0 * kDegree, -1.0, most).ratio, bent * std::pow(std::cos(away), 2),
                3e-3 * bent);
  }
}

TEST(TipDrive, TellsTwistFromOpening) {
  // principal moments across and along a course that turns from one to the other: at 45 degrees they only twist it
  const auto twisted = [](double angle, double lower) { return drive_of(angle, 0.0, lower, 0.0).twisted; };
  EXPECT_FALSE(twisted(0.0, -1.0)) << "bent open";
  EXPECT_FALSE(twisted(40.0 * kDegree, -1.0));
  EXPECT_TRUE(twisted(50.0 * kDegree, -1.0)) << "twist is sin cos of it, opening is cos squared";
  EXPECT_FALSE(twisted(50.0 * kDegree, 1.0)) << "stretched and not bent";
  EXPECT_FALSE(twisted(50.0 * kDegree, 0.5)) << "stretched more than bent";
}

TEST(CriticalLength, IsGriffithsStretchedAndThatOfWilliamsFieldBent) {
  ShellMaterial m = glass();
  m.youngs_modulus = 70e9, m.poisson_ratio = 0.22, m.fracture_energy = 8.0;
  EXPECT_NEAR(critical_length(m, 60e6, 2.0, 0.0), 4.95149e-5, 1e-10);
  EXPECT_NEAR(critical_length(m, 60e6, 0.0, 3.0), 3.92061e-4, 1e-9);   // 3 (3 + nu) / (1 + nu) times as long
  EXPECT_NEAR(critical_length(m, 60e6, -1.0, 3.0), 3.92061e-4, 1e-9);  // pressed as well: it opens by bending
  EXPECT_TRUE(std::isinf(critical_length(m, 60e6, -1.0, 0.0)));
  // both release energy: half a stress by each
  EXPECT_NEAR(1.0 / critical_length(m, 60e6, 1.0, 1.0), 0.25 / 4.95149e-5 + 0.25 / 3.92061e-4, 0.1);
}

// A sheet stores h E e^2 / 2 or h E k^2 h^2 / 24 per area in one direction. Times the area of the circle this is the
// energy of the crack's faces.
TEST(ZoneRadius, StoresWhatTheCrackCosts) {
  ShellMaterial m = glass();
  m.youngs_modulus = 70e9, m.poisson_ratio = 0.22, m.fracture_energy = 8.0;
  const double strength = 60e6, thickness = 1.3e-3, strain = strength / m.youngs_modulus;
  const double curvature = 2.0 * strain / thickness;
  for (const double bent : {0.0, 0.3, 0.7, 1.0}) {
    const double half_length = critical_length(m, strength, 1.0 - bent, bent);
    const double radius = zone_radius(m, half_length, 1.0 - bent, bent);
    const double e = (1.0 - bent) * strain, k = bent * curvature;
    const double stored = m.youngs_modulus * thickness * (e * e / 2.0 + k * k * thickness * thickness / 24.0);
    EXPECT_NEAR(std::numbers::pi * radius * radius * stored / (2.0 * half_length * thickness * m.fracture_energy), 1.0,
                1e-9)
        << "bent " << bent;
  }
  EXPECT_EQ(zone_radius(m, 1e-3, 0.0, 3.0), zone_radius(m, 1e-3, -1.0, 3.0));  // what is pressed drives nothing
}
