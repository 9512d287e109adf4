#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/loads.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

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
          force[d * static_cast<std::size_t>(t.component_stride) + f.slot] += 3.0 * g.weight * f.n[0] * u.cross(v)[d];
    }
  return force;
}

}  // namespace

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
      EXPECT_TRUE(m.loads.rotate_with_surface());
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
