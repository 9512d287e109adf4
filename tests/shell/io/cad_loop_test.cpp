// Borders of CAD faces as polygons: areas are those of the loops, and what runs on an edge of the patch is on it.
#include "shell/io/cad_loop.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "shell/geometry/edges.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kLoopSpacing = 0.05;  // [m]

Patch loop_patch(double width = 1.0, double height = 1.0) {
  return plate(width, height, 20, 20, Vec3::Zero(), Quat::Identity());
}
CadBorder border_line(const Vec2& a, const Vec2& b, int sides = 0) {
  return {{[a, b](double t) { return Vec2(a + t * (b - a)); }, (b - a).norm(), false}, sides};
}
// An arc from one angle to another [rad].
CadBorder border_arc(const Vec2& centre, double radius, double from, double to) {
  return {{[=](double t) {
             const double angle = from + t * (to - from);
             return Vec2(centre + radius * Vec2(std::cos(angle), std::sin(angle)));
           },
           radius * std::abs(to - from), std::abs(to - from) > 6.28},
          0};
}
double signed_area(const std::vector<Vec2>& p) {
  double sum = 0.0;
  for (std::size_t k = 0; k + 1 < p.size(); ++k) sum += 0.5 * (p[k].x() * p[k + 1].y() - p[k].y() * p[k + 1].x());
  return sum;
}
// Expects a closed polygon within the patch.
void expect_polygon(const TrimLoop& loop, const Patch& patch) {
  ASSERT_GE(loop.points.size(), 4u);
  EXPECT_EQ(loop.points.front(), loop.points.back());
  for (std::size_t k = 0; k + 1 < loop.points.size(); ++k) {
    EXPECT_TRUE(patch.contains(loop.points[k])) << loop.points[k].transpose();
    EXPECT_GT((loop.points[k + 1] - loop.points[k]).norm(), 0.0);
  }
}

constexpr double kTurn = 2.0 * std::numbers::pi;

}  // namespace

TEST(CadLoopPolygon, OfStraightBordersKeepsTheirCorners) {
  const Patch patch = loop_patch();
  const std::vector<Vec2> corners{{0.1, 0.2}, {0.8, 0.1}, {0.7, 0.9}};
  CadLoop loop;
  for (std::size_t k = 0; k < 3; ++k) loop.borders.push_back(border_line(corners[k], corners[(k + 1) % 3]));
  const TrimLoop polygon = cad_loop(loop, patch, kLoopSpacing);
  expect_polygon(polygon, patch);
  EXPECT_FALSE(polygon.hole);
  EXPECT_EQ(polygon.curves.size(), 3u);
  for (const Vec2& corner : corners)
    EXPECT_EQ(std::count(polygon.points.begin(), polygon.points.end() - 1, corner), 1) << corner.transpose();
  std::vector<Vec2> triangle = corners;
  triangle.push_back(corners[0]);
  EXPECT_NEAR(signed_area(polygon.points), signed_area(triangle), 1e-15);  // round-off
}

TEST(CadLoopPolygon, OfACircleHasItsArea) {
  const Patch patch = loop_patch();
  for (const double radius : {0.02, 0.05, 0.1, 0.4})
    for (const double turn : {kTurn, -kTurn}) {
      CadLoop loop;
      loop.borders = {border_arc({0.5, 0.5}, radius, 0.3, 0.3 + turn)}, loop.hole = turn < 0.0;
      const TrimLoop polygon = cad_loop(loop, patch, kLoopSpacing);
      expect_polygon(polygon, patch);
      EXPECT_EQ(polygon.hole, turn < 0.0);
      EXPECT_GE(polygon.points.size(), 9u);
      const double area = (turn > 0.0 ? 0.5 : -0.5) * kTurn * radius * radius;
      // An octagon lacks a tenth. The first step makes up for most of that; each of the other two leaves at most
      // 1 - cos(22.5 degrees) of the rest.
      EXPECT_NEAR(signed_area(polygon.points), area, 1e-4 * std::abs(area)) << radius;
      for (const Vec2& p : polygon.points)  // moved outwards by less than the sag of an octagon's chord
        EXPECT_NEAR((p - Vec2(0.5, 0.5)).norm(), radius, (1.0 - std::cos(kTurn / 16.0)) * radius);
    }
}

// Two arcs that meet in corners: the corners stay, and the other points make up for the bends.
TEST(CadLoopPolygon, OfALensKeepsItsTipsAndItsArea) {
  const Patch patch = loop_patch();
  for (const double radius : {0.03, 0.3}) {
    CadLoop loop;  // circles about (0.5 -+ c, 0.5) that meet on x = 0.5
    const double half = std::numbers::pi / 4.0, c = radius * std::cos(half);
    loop.borders = {border_arc({0.5 - c, 0.5}, radius, -half, half),
                    border_arc({0.5 + c, 0.5}, radius, std::numbers::pi - half, std::numbers::pi + half)};
    const TrimLoop polygon = cad_loop(loop, patch, kLoopSpacing);
    expect_polygon(polygon, patch);
    for (const double sign : {-1.0, 1.0}) {
      const Vec2 tip(0.5, 0.5 + sign * radius * std::sin(half));
      double nearest = 1.0;
      for (const Vec2& p : polygon.points) nearest = std::min(nearest, (p - tip).norm());
      EXPECT_LT(nearest, 1e-15);
    }
    const double area = radius * radius * (2.0 * half - std::sin(2.0 * half));  // of two segments of a circle
    EXPECT_NEAR(signed_area(polygon.points), area, 1e-4 * area) << radius;      // as above
  }
}

// Half a disc that stands on the lower edge of the patch; its border there is off by a reader's tolerance.
TEST(CadLoopPolygon, WhatRunsOnAnEdgeOfThePatchIsThere) {
  const Patch patch = loop_patch();
  CadLoop loop;
  loop.borders = {border_line({0.2, 1e-8}, {0.8, -1e-8}, kVMin), border_arc({0.5, 0.0}, 0.3, 0.0, std::numbers::pi)};
  const TrimLoop polygon = cad_loop(loop, patch, kLoopSpacing);
  expect_polygon(polygon, patch);
  int on_edge = 0;
  for (const Vec2& p : polygon.points) {
    if (p.y() > 1e-6) continue;
    EXPECT_EQ(p.y(), patch.knots_v.begin());
    ++on_edge;
  }
  EXPECT_GE(on_edge, 13);  // 0.6 m in edges of at most 0.9 spacings, 0.045 m
  EXPECT_NEAR(signed_area(polygon.points), 0.5 * std::numbers::pi * 0.09, 1e-6);  // 1e-5 of it
}

TEST(CadLoopPolygon, WhatReachesBeyondThePatchIsMovedOntoIt) {
  const Patch patch = loop_patch();
  CadLoop loop;  // touches all four edges, and passes them by a millionth
  loop.borders = {border_arc({0.5, 0.5}, 0.5 + 1e-6, 0.0, kTurn)};
  expect_polygon(cad_loop(loop, patch, kLoopSpacing), patch);
}

TEST(CadLoopPolygon, OfTheWholePatchIsItsBorder) {
  const Patch patch = loop_patch(0.5, 0.25);
  const double u = patch.knots_u.end(), v = patch.knots_v.end();
  CadLoop loop;
  loop.borders = {border_line({0, 0}, {u, 0}, kVMin), border_line({u, 0}, {u, v}, kUMax),
                  border_line({u, v}, {0, v}, kVMax), border_line({0, v}, {0, 0}, kUMin)};
  const TrimLoop polygon = cad_loop(loop, patch, kLoopSpacing);
  expect_polygon(polygon, patch);
  EXPECT_NEAR(signed_area(polygon.points), u * v, 1e-16);  // round-off
  for (const Vec2& corner : {Vec2(0, 0), Vec2(u, 0), Vec2(u, v), Vec2(0, v)})
    EXPECT_GE(std::count(polygon.points.begin(), polygon.points.end(), corner), 1);
}

TEST(ScaledLoops, AreStretchedAlongEachParameter) {
  CadLoop loop;
  loop.borders = {border_line({0.25, 0.5}, {0.75, 1.0}, 0), border_line({0.0, 1.0 + 1e-9}, {0.0, 0.0}, kUMin)};
  loop.hole = true;
  const Patch to = loop_patch(2.0, 6.0);
  const std::vector<CadLoop> scaled = scaled_loops({loop}, loop_patch(), to);
  ASSERT_EQ(scaled.size(), 1u);
  EXPECT_TRUE(scaled[0].hole);
  const CadBorder& first = scaled[0].borders[0];
  EXPECT_LT((first.curve.at(0.0) - Vec2(0.5, 3.0)).norm(), 1e-14);  // round-off
  EXPECT_LT((first.curve.at(0.5) - Vec2(1.0, 4.5)).norm(), 1e-14);
  EXPECT_LT((first.curve.at(1.0) - Vec2(1.5, 6.0)).norm(), 1e-14);
  // the length is a bound: that of the larger scale
  EXPECT_NEAR(first.curve.length, 6.0 * std::sqrt(0.5), 1e-14);
  const CadBorder& second = scaled[0].borders[1];
  EXPECT_EQ(second.sides, kUMin);
  EXPECT_EQ(second.curve.at(0.0).y(), to.knots_v.end());  // not beyond the patch
}
