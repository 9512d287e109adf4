#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "shell/fracture/crack_graph.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(CrackGraph, VisibilityEndsAtAnEdgeAndALittleBeyondItsEnds) {
  CrackGraph g({0, 0}, {1, 1}, 0.1, 0.01);
  const int a = g.add_vertex({0.5, 0.3}), b = g.add_vertex({0.5, 0.6});
  EXPECT_EQ(g.add_edge(a, b, g.new_crack(), 0.0, 0), 0);
  EXPECT_FALSE(g.visible({0.4, 0.5}, {0.6, 0.5}));
  EXPECT_FALSE(g.visible({0.4, 0.605}, {0.6, 0.605}));  // past the vertex by less than the lengthening
  EXPECT_TRUE(g.visible({0.4, 0.62}, {0.6, 0.62}));
  EXPECT_TRUE(g.visible({0.4, 0.4}, {0.49, 0.5}));
  EXPECT_EQ(g.add_edge(a, a, 0, 0.0, 0), -1);  // no length
}

TEST(CrackGraph, EarlierEdgesAreASubsetOfLaterOnes) {
  const ShellModel m = brittle_sheet();
  ShellState s = make_state(m, Vec3::Zero(), 1);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(0.01, 0.19);
  std::vector<CrackEdge> before;
  for (int i = 0; i < 6; ++i) {
    insert_polyline(m, s, {{uniform(random), uniform(random)}, {uniform(random), uniform(random)}}, 1e-5 * i);
    const auto& edges = s.cracks.graph.edges();
    ASSERT_GE(edges.size(), before.size());
    for (std::size_t k = 0; k < before.size(); ++k) {
      EXPECT_EQ(edges[k].a, before[k].a);
      EXPECT_EQ(edges[k].b, before[k].b);
    }
    before = edges;
  }
}

TEST(CrackGraph, AControlPointOnACutKeepsItsPlace) {
  const ShellModel m = brittle_sheet(21);  // odd: Greville points stand in the middle of the sheet
  ShellState s = make_state(m, Vec3::Zero(), 1);
  insert_polyline(m, s, {{0.1, 0.0}, {0.1, 0.2}}, 0.0);
  // lifted by hand, every control point is pulled back: none is seen by nobody
  for (int i = 0; i < m.control_points(); ++i) {
    ShellState lifted = s;
    lifted.motion.x[2 * static_cast<std::size_t>(m.tables.component_stride) + m.tables.slot(i)] += 1e-4;
    compute_forces(m, lifted, false, 0.0, 1);
    EXPECT_LT(lifted.at(lifted.motion.force, m.tables.slot(i)).z(), -1e-3) << "control point " << i;
    if (i > 3 * m.tables.columns) break;
  }
}
