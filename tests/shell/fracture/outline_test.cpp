// Outlines of pieces, and the convex parts that collide in their place.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "shell/fracture/outline.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/parting/pieces.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

double area_of(const std::vector<Vec2>& polygon) {
  double sum = 0.0;
  for (std::size_t k = 2; k < polygon.size(); ++k) sum += triangle_area(polygon[0], polygon[k - 1], polygon[k]);
  return std::abs(sum);
}

double area_of(const Outline& o) {
  double sum = 0.0;
  for (const auto& t : o.triangles) sum += triangle_area(o.vertices[t[0]], o.vertices[t[1]], o.vertices[t[2]]);
  return sum;
}

bool convex(const std::vector<Vec2>& p) {
  double sign = 0.0;
  for (std::size_t k = 0; k < p.size(); ++k) {
    const double turn = orientation(p[k], p[(k + 1) % p.size()], p[(k + 2) % p.size()]);
    if (std::abs(turn) < 1e-12) continue;
    if (sign * turn < 0.0) return false;
    sign = turn;
  }
  return true;
}

/// A square of 0.2 m, from which a cut takes a quarter out of a corner: a square of 0.1 m and an L.
Triangulation corner_cut_out(std::vector<Piece>& pieces) {
  const ShellModel m = brittle_sheet(10);
  ShellState s = make_state(m, Vec3::Zero(), 1);
  insert_polyline(m, s, {{0.1, 0.0}, {0.1, 0.1}, {0.0, 0.1}}, 0.0);
  return partition(m, s, pieces);
}

}  // namespace

TEST(Outline, HasTheAreaOfItsPieceAndABorderAroundIt) {
  std::vector<Piece> pieces;
  const Triangulation t = corner_cut_out(pieces);
  ASSERT_EQ(t.pieces, 2);
  for (const Piece& p : pieces) {
    const Outline o = outline_of(t, p.number);
    EXPECT_NEAR(area_of(o), p.area, 1e-12);
    // the area by its border, which has the piece on its left (Green)
    double around = 0.0;
    for (const auto& [a, b] : o.border)
      around += 0.5 * (o.vertices[a].x() * o.vertices[b].y() - o.vertices[b].x() * o.vertices[a].y());
    EXPECT_NEAR(around, p.area, 1e-12);
    EXPECT_LT(o.triangles.size(), t.triangles_of(p.number).size());  // no vertices inside
  }
}

// A slit of 0.06 m that ends within a square of 0.2 m, and the border around it.
TEST(Outline, HasBothSidesOfACrackThatEndsWithinItsPiece) {
  const ShellModel m = brittle_sheet(10);
  ShellState s = make_state(m, Vec3::Zero(), 1);
  const auto length = [](const Outline& o) {
    double sum = 0.0;
    for (const auto& [a, b] : o.border) sum += (o.vertices[b] - o.vertices[a]).norm();
    return sum;
  };
  std::vector<Piece> pieces;
  EXPECT_FALSE(has_inner_cracks(partition(m, s, pieces), 0));
  insert_polyline(m, s, {{0.07, 0.11}, {0.13, 0.11}}, 0.0);
  const Triangulation t = partition(m, s, pieces);
  ASSERT_EQ(t.pieces, 1);
  EXPECT_TRUE(has_inner_cracks(t, 0));
  const Outline without = outline_of(t, 0), with = outline_with_cracks(t, 0);
  EXPECT_NEAR(length(without), 0.8, 1e-12);
  EXPECT_NEAR(length(with), 0.8 + 2.0 * 0.06, 1e-9);
  EXPECT_NEAR(area_of(with), pieces[0].area, 1e-12);
}

TEST(ConvexParts, CoverAnLExactlyByConvexPolygons) {
  std::vector<Piece> pieces;
  const Triangulation t = corner_cut_out(pieces);
  for (const Piece& p : pieces) {
    const auto parts = convex_parts(outline_of(t, p.number), 1e-9);
    double sum = 0.0;
    for (const auto& polygon : parts) {
      EXPECT_TRUE(convex(polygon));
      sum += area_of(polygon);
    }
    EXPECT_NEAR(sum, p.area, 1e-9 * static_cast<double>(parts.size()));
    EXPECT_LE(parts.size(), p.area < 0.02 ? 2u : 4u);  // the square, and the L, as they are merged pair by pair
  }
}

TEST(ConvexParts, AreFewerWhereMoreMayBeAdded) {
  std::vector<Piece> pieces;
  const Triangulation t = corner_cut_out(pieces);
  const int l = pieces[0].area > 0.02 ? pieces[0].number : pieces[1].number;
  const auto one = convex_parts(outline_of(t, l), 0.01);  // the corner's triangle is 0.005 m^2
  ASSERT_EQ(one.size(), 1u);
  EXPECT_NEAR(area_of(one[0]), 0.03 + 0.005, 1e-9);
}
