#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/io/probes.h"
#include "shell/solver/forces.h"
#include "shell/solver/statics/relaxation.h"
#include "shell/solver/stepping/kick_drift.h"
#include "shell/solver/stepping/stable_step.h"
#include "shell/solver/supports.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"

using namespace sunder;
using namespace sunder::shell;

TEST(Supports, HoldTheAxesThatTheyName) {
  Support s;
  s.edges = kUMin, s.clamped = false, s.axes = {true, false, true};
  const ShellModel m = strip({s}, {});
  EXPECT_EQ(m.constraints.held[0].size(), static_cast<std::size_t>(m.tables.rows));
  EXPECT_TRUE(m.constraints.held[1].empty());
  EXPECT_TRUE(m.constraints.partial);
  for (const char h : m.held) EXPECT_EQ(h, 0);
  Support nowhere;
  nowhere.regions = {{Vec2(2, 2), Vec2(3, 3)}};
  EXPECT_THROW(strip({nowhere}, {}), Error);
  Support skew;
  skew.edges = kUMin, skew.symmetry = 1;  // that edge runs along y
  EXPECT_THROW(strip({skew}, {}), Error);
}

TEST(Supports, AControlPointCountsWithTheFirstPartThatHoldsIt) {
  Support both, corner, box, push;
  both.edges = kUMin | kVMax, both.clamped = false, both.axes = {true, false, true};
  corner.corners = kUMinVMax | kUMaxVMin, corner.clamped = false;
  box.regions = {{Vec2(0.45, 0.0), Vec2(0.55, 0.2)}};
  push.edges = kUMin | kUMax, push.clamped = false, push.motion = {{0.0, Vec3::Zero()}};
  const ShellModel m = strip({both, corner, box, push}, {});
  const Constraints& c = m.constraints;
  std::vector<std::string> names;
  for (const Constraints::Part& part : c.parts) names.push_back(part.name);
  EXPECT_EQ(names, (std::vector<std::string>{"support_0_u_min", "support_0_v_max", "support_1_corner_u_max_v_min",
                                             "support_1_corner_u_min_v_max", "support_2_region_0", "support_3_u_min",
                                             "support_3_u_max"}));
  const auto rows = static_cast<std::size_t>(m.tables.rows), columns = static_cast<std::size_t>(m.tables.columns);
  EXPECT_EQ(c.parts[0].slots[0].size(), rows);
  EXPECT_EQ(c.parts[1].slots[0].size(), columns - 1);  // their common corner is u_min's
  EXPECT_EQ(c.parts[3].slots[0].size(), 0u);           // both edges have it along x and z
  EXPECT_EQ(c.parts[3].slots[1].size(), 1u);
  EXPECT_EQ(c.parts[5].slots[0].size(), 0u);        // held wins over driven
  EXPECT_EQ(c.parts[5].slots[1].size(), rows - 1);  // the corner is held along y
  EXPECT_EQ(c.parts[6].slots[2].size(), rows - 2);  // one end is v_max's, one the corner's
  for (int d = 0; d < 3; ++d) {                     // each slot that is held or driven is in one part
    std::multiset<int> in_parts, in_all(c.held[d].begin(), c.held[d].end());
    for (const Constraints::Part& part : c.parts) in_parts.insert(part.slots[d].begin(), part.slots[d].end());
    for (const Constraints::Driven& driven : c.driven) in_all.insert(driven.slots[d].begin(), driven.slots[d].end());
    EXPECT_EQ(in_parts, in_all);
  }
}

TEST(Supports, AHalfWithSymmetryBendsAsTheWhole) {
  Support hinge, hinges, middle;
  hinge.edges = kUMin, hinge.clamped = false;
  hinges = hinge, hinges.edges = kUMin | kUMax;
  middle.edges = kUMax, middle.symmetry = 0;
  Load load;
  load.kind = Load::Kind::kPressure, load.size = 50.0;
  ShellMaterial g = glass();
  const ShellModel whole =
      make_shell("w", plate(1.0, 0.2, 20, 4, Vec3(0.5, 0.1, 0), Quat::Identity()), 0.01, g, 2, 2, {hinges}, {load});
  const ShellModel half = make_shell("h", plate(0.5, 0.2, 10, 4, Vec3(0.25, 0.1, 0), Quat::Identity()), 0.01, g, 2, 2,
                                     {hinge, middle}, {load});
  ShellState a = make_state(whole, Vec3::Zero(), 0), b = make_state(half, Vec3::Zero(), 0);
  RelaxationRules rules;
  rules.tolerance = 1e-9;
  EXPECT_TRUE(relax(whole, a, rules).converged);
  EXPECT_TRUE(relax(half, b, rules).converged);
  const double w = displacement(whole, a, {0.5, 0.1}).z();
  EXPECT_GT(w, 1e-6);
  // the symmetric slope is that of two control points, exact in the whole model only to the spacing squared
  EXPECT_NEAR(displacement(half, b, {0.5, 0.1}).z() / w, 1.0, 2e-3);
}

TEST(Supports, ADrivenEdgeOfSymmetryKeepsItsSlopeAndHeldWinsOverDriven) {
  Support hinge, middle, push;
  hinge.edges = kUMin, hinge.clamped = false;
  middle.edges = kUMax, middle.symmetry = 0;
  push.edges = kUMax, push.clamped = false, push.axes = {false, false, true};
  push.motion = {{0.0, Vec3(0, 0, 1e-3)}};
  const ShellModel m = strip({hinge, middle, push}, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  RelaxationRules rules;
  EXPECT_TRUE(relax(m, s, rules).converged);
  // beam theory, half a simply supported beam with its middle pushed down: w = 1/2 x (3 - x^2)
  EXPECT_NEAR(displacement(m, s, {1.0, 0.1}).z(), 1e-3, 1e-12);
  EXPECT_NEAR(displacement(m, s, {0.5, 0.1}).z(), 0.6875e-3, 0.003e-3);
  Support along;
  along.edges = kVMin, along.clamped = false, along.axes = {false, false, true}, along.motion = push.motion;
  const ShellModel both = strip({hinge, along}, {});
  std::set<int> seen(both.constraints.held[2].begin(), both.constraints.held[2].end());
  for (const int slot : both.constraints.driven[0].slots[2]) EXPECT_TRUE(seen.insert(slot).second);
}

TEST(Supports, PrescribedMotionMovesAndItsWorkIsBooked) {
  Support clamp, pull;
  clamp.edges = kUMin;
  pull.edges = kUMax, pull.clamped = false, pull.axes = {true, false, true};
  pull.motion = {{0.0, Vec3::Zero()}, {1e-3, Vec3(1e-5, 0, 0)}};
  Rig rig(setup_of({{strip({clamp, pull}, {})}}));
  const ShellModel& m = rig.model();
  ShellState& s = rig.state();
  const double dt = 0.8 * stable_step(m, s, 150, 1, false);
  double scale = 0.0, energy = 0.0;
  while (s.motion.time < 2e-3) {
    energy = compute_forces(m, s, true, 0.0, 1) + kinetic_energy(m, s, dt);
    scale = std::max(scale, energy);
    // the half kick that energies have already is booked with the next one; round-off of displacements of 1e-5 m
    EXPECT_NEAR(energy - 0.5 * dt * external_power(m, s), s.book.external, 1e-6 * scale + 1e-12) << s.motion.time;
    rig.step(dt);
  }
  EXPECT_NEAR(displacement(m, s, {1.0, 0.1}).x(), 1e-5, 1e-12);
  EXPECT_GT(s.book.external, 0.0);
}
