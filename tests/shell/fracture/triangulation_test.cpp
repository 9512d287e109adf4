#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "shell/fracture/outline.h"
#include "shell/fracture/triangulation.h"
#include "shell/solver/cracking/polyline.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(Triangulation, EveryCutFromBorderToBorderMakesTwoPieces) {
  const ShellModel m = brittle_sheet();
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform(0.003, 0.197);
  for (int k = 0; k < 200; ++k) {
    const auto on_border = [&](int side) {
      const double at = uniform(random);
      return side == 0 ? Vec2(0.0, at) : side == 1 ? Vec2(0.2, at) : side == 2 ? Vec2(at, 0.0) : Vec2(at, 0.2);
    };
    const Vec2 a = on_border(k % 4), b = on_border((k % 4 + 1 + k / 4 % 3) % 4);
    if ((b - a).norm() < 0.02) continue;
    ShellState s = make_state(m, Vec3::Zero(), 1);
    insert_polyline(m, s, {a, b}, 0.0);
    std::vector<Piece> pieces;
    EXPECT_EQ(partition(m, s, pieces).pieces, 2) << a.transpose() << " to " << b.transpose();
  }
}

TEST(Triangulation, ACutThatEndsOnACrackLeavesNoGap) {
  const ShellModel m = brittle_sheet();
  for (const double off : {-1e-4, -1e-6, -1e-16, 0.0, 1e-6, 1e-4}) {  // short of it, on it, past it [m]
    ShellState s = make_state(m, Vec3::Zero(), 1);
    insert_polyline(m, s, {{0.0, 0.071}, {0.2, 0.093}}, 0.0);
    insert_polyline(m, s, {{0.151, 0.0}, {0.151, 0.071 + 0.022 * 0.151 / 0.2 + off}}, 0.0);
    std::vector<Piece> pieces;
    EXPECT_EQ(partition(m, s, pieces).pieces, 3) << off;
  }
}

TEST(Triangulation, PiecesCoverTheSheetAndAreWhatTheCutsLeave) {
  const ShellModel m = brittle_sheet();
  ShellState s = make_state(m, Vec3::Zero(), 1);
  insert_polyline(m, s, {{0.08, 0.0}, {0.11, 0.2}}, 0.0);    // two halves
  insert_polyline(m, s, {{0.0, 0.07}, {0.2, 0.09}}, 0.0);    // four quarters
  insert_polyline(m, s, {{0.15, 0.13}, {0.17, 0.15}}, 0.0);  // a slit: no new piece
  std::vector<Piece> pieces;
  const Triangulation t = partition(m, s, pieces);
  ASSERT_EQ(t.pieces, 4);
  double sum = 0.0;
  std::size_t points = 0;
  for (const Piece& p : pieces) {
    sum += p.area, points += p.control_points.size();
    double covered = 0.0, parts = 0.0;
    const Outline o = outline_of(t, p.number);
    for (const auto& c : o.triangles) covered += triangle_area(o.vertices[c[0]], o.vertices[c[1]], o.vertices[c[2]]);
    for (const auto& hull : convex_parts(o, 1e-8))
      for (std::size_t k = 1; k + 1 < hull.size(); ++k) parts += triangle_area(hull[0], hull[k], hull[k + 1]);
    EXPECT_NEAR(covered, p.area, 1e-12);
    EXPECT_NEAR(parts, p.area, 1e-7);  // each part may add 1e-8
  }
  EXPECT_NEAR(sum, 0.04, 1e-14);
  EXPECT_EQ(points, static_cast<std::size_t>(m.control_points()));
  // the quarter at the origin, by the shoelace formula from where the straight cuts meet
  const double v = (0.07 + 0.1 * 0.08) / (1 - 0.1 * 0.15), u = 0.08 + 0.15 * v;
  const Vec2 polygon[4] = {{0, 0}, {0.08, 0}, {u, v}, {0, 0.07}};
  double area = 0.0;
  for (int k = 0; k < 4; ++k)
    area += 0.5 * (polygon[k].x() * polygon[(k + 1) % 4].y() - polygon[k].y() * polygon[(k + 1) % 4].x());
  double nearest = 1.0;
  for (const Piece& p : pieces) nearest = std::min(nearest, std::abs(p.area - area));
  EXPECT_LT(nearest, 1e-12);
}
