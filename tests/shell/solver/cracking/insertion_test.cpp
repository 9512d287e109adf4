// New edges enter the mechanics: what they give Gauss points, and which are refused.
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "shell/mechanics/principal.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/nucleation.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(ExtendCracks, ThatWouldAddEnergyIsRefusedAndChangesNothing) {
  const ShellModel m = brittle_sheet();
  ShellState s = make_state(m, Vec3::Zero(), 1);
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (double& x : s.motion.x) x += 1e-5 * uniform(random);
  ShellState forgetful = s;  // of what was tried before: the same comes of it
  int refused = 0, taken = 0;
  for (int k = 0; k < 60; ++k) {
    const Vec2 from(0.1 + 0.06 * uniform(random), 0.1 + 0.06 * uniform(random));
    const Vec2 to = from + 0.75 * m.spacing * turned(Vec2(1, 0), 3.0 * uniform(random));
    const int vertex = s.cracks.graph.add_vertex(from);
    const std::size_t edges = s.cracks.graph.edges().size(), vertices = s.cracks.graph.vertices().size(),
                      points = s.cracked.gathered.size();
    const double length = s.cracks.graph.total_length(), energy = compute_forces(m, s, true, 0.0, 1);
    const int edge = extend_cracks(m, s, {{vertex, to, k, 1}}, 0.0, false);
    forgetful.cracks.graph.add_vertex(from), forgetful.caches.trials.clear();
    EXPECT_EQ(extend_cracks(m, forgetful, {{vertex, to, k, 1}}, 0.0, false), edge);
    if (edge < 0) {  // once more, by what is remembered
      EXPECT_LT(extend_cracks(m, s, {{vertex, to, k, 1}}, 0.0, false), 0);
    }
    EXPECT_EQ(compute_forces(m, forgetful, true, 0.0, 1), compute_forces(m, s, true, 0.0, 1));
    EXPECT_EQ(forgetful.motion.force, s.motion.force);
    EXPECT_EQ(s.book.injected, 0.0);
    if (edge >= 0) {
      EXPECT_LE(compute_forces(m, s, true, 0.0, 1), energy * (1.0 + 1e-12));
      ++taken;
      continue;
    }
    EXPECT_EQ(s.cracks.graph.edges().size(), edges);
    EXPECT_EQ(s.cracks.graph.vertices().size(), vertices);
    EXPECT_EQ(s.cracked.gathered.size(), points);
    EXPECT_NEAR(s.cracks.graph.total_length(), length, 1e-15);
    EXPECT_EQ(compute_forces(m, s, true, 0.0, 1), energy);
    ++refused;
  }
  EXPECT_GT(refused, 0);
  EXPECT_GT(taken, 0);
}

// Shape functions beside cracks reproduce a constant and, where they bend, planes.
TEST(InsertEdge, LeavesEachPointFunctionsThatSumToOne) {
  const ShellModel m = brittle_sheet();
  ShellState s = make_state(m, Vec3::Zero(), 1);
  insert_polyline(m, s, {{0.0, 0.071}, {0.13, 0.093}, {0.15, 0.17}}, 0.0);
  int seen = 0;
  const double h = m.spacing;
  for (const GatheredPoint& g : s.cracked.gathered) {
    EXPECT_EQ(s.cracked.point_of[static_cast<std::size_t>(g.block) * m.tables.lanes + g.lane],
              static_cast<int>(&g - s.cracked.gathered.data()));
    if (g.kind == PointKind::kDead) continue;
    ++seen;
    double one = 0.0, slope_u = 0.0, slope_v = 0.0;
    Vec2 at = Vec2::Zero();
    for (const GatheredFunction& f : g.functions) {
      one += f.n[0], slope_u += f.n[1], slope_v += f.n[2], at += f.n[0] * m.parameter_of_slot[f.slot];
    }
    EXPECT_NEAR(one, 1.0, 1e-12);
    EXPECT_NEAR(slope_u, 0.0, 1e-11 / h);
    EXPECT_NEAR(slope_v, 0.0, 1e-11 / h);
    EXPECT_LT((at - gauss_point(m.patch, m.tables, g.block, g.lane).parameter).norm(), 1e-11);
  }
  EXPECT_GT(seen, 50);
}

TEST(InsertEdge, WithoutLengthIsRefusedAndChangesNothing) {
  const ShellModel m = brittle_sheet(10);
  ShellState s = make_state(m, Vec3::Zero(), 1);
  const int a = s.cracks.graph.add_vertex({0.1, 0.1}), b = s.cracks.graph.add_vertex({0.1, 0.1});
  EXPECT_EQ(insert_edge(m, s, a, b, s.cracks.graph.new_crack(), 0.0, 0, true), -1);
  EXPECT_TRUE(s.cracks.graph.edges().empty());
  EXPECT_TRUE(s.cracked.gathered.empty());
  EXPECT_EQ(s.book.fracture, 0.0);
}

// Where nothing is strained no energy goes anywhere; where the sheet is stretched across the edge, what it stored
// there is booked.
TEST(InsertEdge, BooksTheEnergyThatTheStoredOneFallsBy) {
  const ShellModel m = brittle_sheet(10);
  for (const double strain : {0.0, 1e-3}) {
    ShellState s = make_state(m, Vec3::Zero(), 1);
    for (int i = 0; i < m.control_points(); ++i)
      s.motion.x[m.tables.component_stride + m.tables.slot(i)] *= 1.0 + strain;
    const double before = compute_forces(m, s, true, 0.0, 1);
    const int a = s.cracks.graph.add_vertex({0.08, 0.1}), b = s.cracks.graph.add_vertex({0.11, 0.1});
    ASSERT_EQ(insert_edge(m, s, a, b, s.cracks.graph.new_crack(), 0.0, 1, false), 0);
    const double after = compute_forces(m, s, true, 0.0, 1);
    EXPECT_NEAR(s.book.fracture - s.book.injected, before - after, 1e-10 * before + 1e-18) << strain;
  }
}

TEST(GatherPoint, KeepsTheForceAndIsTheSameASecondTime) {
  const ShellModel m = brittle_sheet(6);
  ShellState s = make_state(m, Vec3::Zero(), 1);
  disturb(s, m, 1e-5);
  compute_forces(m, s, false, 0.0, 1);
  const std::vector<double> rows = s.motion.force;
  const int first = gather_point(m, s, 3, 2);
  EXPECT_EQ(gather_point(m, s, 3, 2), first);
  EXPECT_NE(gather_point(m, s, 3, 1), first);
  EXPECT_EQ(s.cracked.gathered.size(), 2u);
  compute_forces(m, s, false, 0.0, 1);
  double scale = 0.0;
  for (const double f : rows) scale = std::max(scale, std::abs(f));
  for (std::size_t k = 0; k < rows.size(); ++k) EXPECT_NEAR(s.motion.force[k], rows[k], 1e-12 * scale);
}
