// Whether an edge closes a loop, and so may make a piece.
#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <utility>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "shell/fracture/crack_loops.h"
#include "shell/fracture/triangulation.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/wanderers.h"

using namespace sunder;
using namespace sunder::shell;

TEST(CrackLoops, NoPieceIsAddedUnlessALoopHasClosed) {
  const ShellModel m = wandered_sheet();
  int edges = 0, alarms = 0, pieces = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Wanderers w{m, {Vec2::Zero(), Vec2(kSide, kSide), 0.02, 1e-4}, std::mt19937_64(seed)};
    CrackLoops loops;
    int before = 1;
    const std::array all{domain_of(m)};
    w.start();
    while (w.graph.edges().size() < 150) {
      const std::size_t known = w.graph.edges().size();
      w.step();
      if (w.graph.edges().size() == known) continue;
      const bool closed = loops.closed(w.graph, Vec2::Zero(), Vec2(kSide, kSide), m.spacing);
      const int now = triangulate(m.patch.knots_u, m.patch.knots_v, w.graph, {}, m.spacing, 0.0, all).pieces;
      EXPECT_TRUE(closed || now == before) << "edge " << known << " of seed " << seed;
      ++edges, alarms += closed, before = now;
    }
    pieces += before;
    // knots among the vertices draw the pieces finer and leave them the same
    const auto pieces_of = [&](std::span<const Eigen::AlignedBox2d> knots_in) {
      return triangulate(m.patch.knots_u, m.patch.knots_v, w.graph, m.parameter, m.spacing,
                         0.02 * m.spacing * m.spacing, knots_in);
    };
    const Triangulation fine = pieces_of(all), coarse = pieces_of({});
    EXPECT_EQ(fine.pieces, coarse.pieces);
    EXPECT_LT(coarse.triangles.size(), fine.triangles.size());
    // and so do knots in the box of one alone, to the triangle
    for (int piece = 0; piece < fine.pieces; ++piece) {
      const auto extent = [](const Triangulation& t, int number) {
        Eigen::AlignedBox2d box;
        double area = 0.0;
        for (const int i : t.triangles_of(number)) {
          const auto& c = t.triangles[i];
          EXPECT_EQ(t.piece[i], number);
          for (const int corner : c) box.extend(t.vertices[corner]);
          area += triangle_area(t.vertices[c[0]], t.vertices[c[1]], t.vertices[c[2]]);
        }
        return std::pair(box, area);
      };
      const auto owned = std::find(fine.owner.begin(), fine.owner.end(), piece);
      if (owned == fine.owner.end()) continue;
      const auto [box, area] = extent(fine, piece);
      const Triangulation local = pieces_of(std::array{box});
      const int number = local.owner[owned - fine.owner.begin()];
      EXPECT_EQ(local.triangles_of(number).size(), fine.triangles_of(piece).size());
      EXPECT_NEAR(extent(local, number).second, area, 1e-12);
    }
    std::map<int, int> same;
    for (std::size_t k = 0; k < fine.owner.size(); ++k)
      EXPECT_EQ(same.try_emplace(fine.owner[k], coarse.owner[k]).first->second, coarse.owner[k]);
  }
  EXPECT_GT(pieces, 60);
  EXPECT_LT(alarms, 2 * pieces);
  EXPECT_LT(alarms, edges / 3);
}

TEST(CrackLoops, AnEdgeBackToTheFirstVertexClosesOne) {
  CrackGraph g(Vec2::Zero(), Vec2(1.0, 1.0), 0.1, 1e-3);
  CrackLoops loops;
  const int crack = g.new_crack(), a = g.add_vertex({0.3, 0.3}), b = g.add_vertex({0.6, 0.3}),
            c = g.add_vertex({0.5, 0.6});
  g.add_edge(a, b, crack, 0.0, 0), g.add_edge(b, c, crack, 0.0, 0);
  EXPECT_FALSE(loops.closed(g, Vec2::Zero(), Vec2(1.0, 1.0), 0.05));
  g.add_edge(c, a, crack, 0.0, 0);
  EXPECT_TRUE(loops.closed(g, Vec2::Zero(), Vec2(1.0, 1.0), 0.05));
}

TEST(CrackLoops, OneEdgeFromBorderToBorderClosesOne) {
  for (const bool across : {true, false}) {
    CrackGraph g(Vec2::Zero(), Vec2(1.0, 1.0), 0.1, 1e-3);
    CrackLoops loops;
    g.add_edge(g.add_vertex({0.3, -0.1}), g.add_vertex({0.4, across ? 1.1 : 0.9}), g.new_crack(), 0.0, 0);
    EXPECT_EQ(loops.closed(g, Vec2::Zero(), Vec2(1.0, 1.0), 0.05), across);
  }
}
