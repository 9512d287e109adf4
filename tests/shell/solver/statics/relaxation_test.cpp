// Patches of common shape, supports, loads and equilibrium.
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/geometry/builders.h"
#include "shell/io/probes.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/statics/relaxation.h"
#include "shell/solver/stepping/kick_drift.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kPi = std::numbers::pi;

ShellModel strip(const std::vector<Support>& supports, const std::vector<Load>& loads, double poisson = 0.0) {
  ShellMaterial m = glass();
  m.poisson_ratio = poisson;
  return make_shell("strip", plate(1.0, 0.2, 20, 4, Vec3(0.5, 0.1, 0), Quat::Identity()), 0.01, m, 2, 2, supports,
                    loads);
}

Vec3 total(const ShellModel& m, const ShellState& s) {
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < m.control_points(); ++i) sum += s.at(s.motion.external, m.tables.slot(i));
  return sum;
}

// Pressure of 3 Pa, Gauss point by Gauss point, each with the functions that it has now.
std::vector<double> pressure_by_points(const ShellModel& m, const ShellState& s) {
  std::vector<double> force(s.motion.x.size(), 0.0);
  const RowTables& t = s.cracked.tables;
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e) {
      const GaussPoint g = gauss_point(m.patch, t, q, e);
      const int point = s.cracked.point_of[static_cast<std::size_t>(q) * t.lanes + e];
      if (g.weight == 0.0) continue;
      std::vector<GatheredFunction> functions = patch_functions(m.patch, g.parameter, t.stride);
      if (point >= 0 && !s.cracked.gathered[point].in_rows) functions = s.cracked.gathered[point].functions;
      Vec3 u = Vec3::Zero(), v = Vec3::Zero();
      for (const GatheredFunction& f : functions) u += f.n[1] * s.position(f.slot), v += f.n[2] * s.position(f.slot);
      for (const GatheredFunction& f : functions)
        for (int d = 0; d < 3; ++d)
          force[d * static_cast<std::size_t>(t.plane) + f.slot] += 3.0 * g.weight * f.n[0] * u.cross(v)[d];
    }
  return force;
}

}  // namespace

TEST(Builders, SurfacesOfRevolutionAreExact) {
  const Patch c = cylinder(2.0, 3.0, 1.2, 5, 3), s = sphere(2.0, 1.1, -0.4, 0.5 * kPi, 4, 6),
              k = cone(2.0, 0.5, 3.0, 0.9, 3, 2);
  EXPECT_EQ(c.columns(), 7);
  EXPECT_EQ(c.rows(), 5);
  for (double u = 0.0; u <= 1.0; u += 0.1)
    for (double v = 0.0; v <= 1.0; v += 0.1) {
      const Vec3 a = c.evaluate({u, v}).x, b = s.evaluate({u, v}).x, d = k.evaluate({u, v}).x;
      EXPECT_NEAR(a.head<2>().norm(), 2.0, 1e-14);
      EXPECT_LE(std::abs(std::atan2(a.y(), a.x())), 0.6 + 1e-14);
      EXPECT_NEAR(b.norm(), 2.0, 1e-14);
      EXPECT_NEAR(d.head<2>().norm(), 2.0 - 0.5 * d.z(), 1e-14);
    }
  EXPECT_NEAR(s.evaluate({0.3, 1.0}).x.z(), 2.0, 1e-14);  // the pole
  EXPECT_THROW(cylinder(1.0, 1.0, 3.0, 4, 4), Error);
  EXPECT_THROW(sphere(1.0, 1.0, 0.3, 0.2, 4, 4), Error);
}

TEST(Builders, RefinementLeavesARationalSurfaceAsItIs) {
  const Patch coarse = sphere(1.0, 1.0, 0.0, 1.2, 1, 1), fine = refined(coarse, 7, 3);
  for (double u = 0.03; u < 1.0; u += 0.19)
    for (double v = 0.01; v < 1.0; v += 0.17) {
      const SurfacePoint a = coarse.evaluate({u, v}), b = fine.evaluate({u, v});
      EXPECT_LT((a.x - b.x).norm(), 1e-14);
      EXPECT_LT((a.uv - b.uv).norm(), 1e-12);
      EXPECT_LT((a.vv - b.vv).norm(), 1e-12);
    }
  EXPECT_THROW(refined(fine, 8, 3), Error);  // no multiple of 7
}

TEST(Loads, SumToWhatTheyAre) {
  Load point, force, pressure;
  point.point = Vec2(0.33, 0.07), point.force = Vec3(1, 2, 3);
  force.kind = Load::Kind::kEdgeForce, force.edges = kUMax, force.force = Vec3(0, 5, -1);
  pressure.kind = Load::Kind::kPressure, pressure.size = 10.0, pressure.in_time = {{0.0, 0.0}, {2.0, 4.0}};
  for (const auto& [load, expected] : {std::pair{point, Vec3(1, 2, 3)}, std::pair{force, Vec3(0, 1.0, -0.2)},
                                       std::pair{pressure, Vec3(0, 0, 10.0 * 0.2 * 2.0)}}) {
    const ShellModel m = strip({}, {load});
    ShellState s = make_state(m, Vec3::Zero(), 0);
    s.motion.time = 1.0;
    compute_forces(m, s, false, 0.0, 1);
    EXPECT_LT((total(m, s) - expected).norm(), 1e-12);
  }
}

TEST(Loads, PressureIsThatOfEveryGaussPointAsItStands) {
  Load one, two;  // one rises, the other is there from the start
  one.kind = two.kind = Load::Kind::kPressure, one.size = 4.0, two.size = 1.0, one.in_time = {{0.0, 0.0}, {2.0, 1.0}};
  const KnotVector cubic({0, 0, 0, 0, 0.3, 0.5, 0.5, 1, 1, 1, 1}, 3, "u"),
      other({0, 0, 0, 0, 0.4, 1, 1, 1, 1}, 3, "v");  // one knot is double
  for (const Patch& patch : {plate(1.0, 0.5, 21, 9, Vec3::Zero(), Quat::Identity()), rational_patch(),
                             plate(1.0, 0.5, 15, 6, Vec3::Zero(), Quat::Identity(), 3), rational_patch(cubic, other)})
    for (const bool cut : {false, true}) {
      if (cut && patch.rational()) continue;  // too few elements for a cut
      const ShellModel m = make_shell("m", patch, 0.01, glass(), 2, patch.degree(), {}, {one, two});
      EXPECT_TRUE(m.loads.follow());
      EXPECT_EQ(m.loads.last_change(), 2.0);
      ShellState s = make_state(m, Vec3::Zero(), 0);
      if (cut) insert_polyline(m, s, {Vec2(0.3, 0.21), Vec2(0.7, 0.32)}, 0.0);
      EXPECT_EQ(cut, !s.cracked.gathered.empty());
      disturb(s, m, 0.1 * m.spacing);
      s.motion.time = 1.0;
      compute_forces(m, s, false, 0.0, 1);
      const std::vector<double> expected = pressure_by_points(m, s), alone = s.motion.external;
      double worst = 0.0, scale = 0.0;
      for (std::size_t i = 0; i < expected.size(); ++i)
        worst = std::max(worst, std::abs(s.motion.external[i] - expected[i])),
        scale = std::max(scale, std::abs(expected[i]));
      EXPECT_LT(worst, 1e-13 * scale) << patch.degree() << patch.rational() << cut;
      compute_forces(m, s, false, 0.0, 2);
      EXPECT_EQ(s.motion.external, alone);
    }
}

TEST(Loads, AnEdgeMomentTurnsAndDoesNotPush) {
  Load moment;
  moment.kind = Load::Kind::kEdgeMoment, moment.edges = kUMax, moment.size = 7.0;
  const ShellModel m = strip({}, {moment});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  compute_forces(m, s, false, 0.0, 1);
  Vec3 torque = Vec3::Zero();
  for (int i = 0; i < m.control_points(); ++i)
    torque += s.position(m.tables.slot(i)).cross(s.at(s.motion.external, m.tables.slot(i)));
  EXPECT_LT(total(m, s).norm(), 1e-12);
  // the outside of the edge, +x, turns towards the normal, +z: about -y, 7 N m per m over 0.2 m
  EXPECT_LT((torque - Vec3(0, -1.4, 0)).norm(), 1e-12);
}

TEST(Loads, RefusesAPointOutsideThePatch) {
  Load point;
  point.point = Vec2(1.2, 0.1);
  EXPECT_THROW(strip({}, {point}), Error);
}

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

TEST(Supports, PrescribedMotionMovesAndItsWorkIsBooked) {
  Support clamp, pull;
  clamp.edges = kUMin;
  pull.edges = kUMax, pull.clamped = false, pull.axes = {true, false, true};
  pull.motion = {{0.0, Vec3::Zero()}, {1e-3, Vec3(1e-5, 0, 0)}};
  const ShellModel m = strip({clamp, pull}, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const double dt = 0.8 * stable_step(m, s, 150, 1, false);
  double scale = 0.0, energy = 0.0;
  while (s.motion.time < 2e-3) {
    energy = compute_forces(m, s, true, 0.0, 1) + kinetic_energy(m, s, dt);
    scale = std::max(scale, energy);
    // the half kick that energies have already is booked with the next one; round-off of displacements of 1e-5 m
    EXPECT_NEAR(energy - 0.5 * dt * external_power(m, s), s.book.external, 1e-6 * scale + 1e-12) << s.motion.time;
    kick(m, s, Vec3::Zero(), dt), constrain(m, s, dt), drift(m, s, dt);
  }
  EXPECT_NEAR(displacement(m, s, {1.0, 0.1}).x(), 1e-5, 1e-12);
  EXPECT_GT(s.book.external, 0.0);
}
