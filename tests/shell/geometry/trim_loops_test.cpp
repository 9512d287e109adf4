#include "shell/geometry/trim_loops.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace sunder::shell {
namespace {

std::vector<Vec2> ring(const Vec2& centre, double radius, int corners, double turn) {
  std::vector<Vec2> out;
  for (int k = 0; k <= corners; ++k) {
    const double angle = turn + 2.0 * std::numbers::pi * (k % corners) / corners;
    out.push_back(centre + radius * Vec2(std::cos(angle), std::sin(angle)));
  }
  return out;
}

double polygon_area(double radius, int corners) {
  return 0.5 * corners * radius * radius * std::sin(2.0 * std::numbers::pi / corners);
}

// An octagon with a square hole in a domain of 2 x 2.
TrimLoops octagon_with_a_hole() {
  return {Vec2::Zero(),
          Vec2::Constant(2.0),
          {{ring({1.0, 0.9}, 0.8, 8, 0.1), false}, {ring({1.1, 1.0}, 0.3, 4, 0.3), true}}};
}

}  // namespace

TEST(TrimLoops, TurnOutlinesCounterClockwiseAndHolesClockwise) {
  std::vector<Vec2> outline = ring({1.0, 1.0}, 0.8, 8, 0.0);
  std::reverse(outline.begin(), outline.end());
  const TrimLoops loops(Vec2::Zero(), Vec2::Constant(2.0), {{outline, false}, {ring({1.0, 1.0}, 0.3, 5, 0.0), true}});
  EXPECT_NEAR(loops.area(), polygon_area(0.8, 8) - polygon_area(0.3, 5), 1e-14);
}

TEST(TrimLoops, WithoutAnOutlineTheDomainIsOne) {
  const TrimLoops loops(Vec2::Zero(), Vec2::Constant(2.0), {{ring({1.0, 1.0}, 0.3, 5, 0.0), true}});
  EXPECT_NEAR(loops.area(), 4.0 - polygon_area(0.3, 5), 1e-14);
  EXPECT_TRUE(loops.contains({0.1, 0.1}));
  EXPECT_FALSE(loops.contains({1.0, 1.0}));
}

TEST(TrimLoops, ContainPointsOnThem) {
  const TrimLoops loops = octagon_with_a_hole();
  for (const TrimLoop& loop : loops.loops())
    for (std::size_t k = 0; k + 1 < loop.points.size(); ++k) {
      const Vec2 middle = 0.5 * (loop.points[k] + loop.points[k + 1]), along = loop.points[k + 1] - loop.points[k];
      const Vec2 left = Vec2(-along.y(), along.x()).normalized();
      EXPECT_TRUE(loops.contains(middle));
      EXPECT_TRUE(loops.contains(middle + 1e-6 * left));
      EXPECT_FALSE(loops.contains(middle - 1e-6 * left));
      EXPECT_TRUE(loops.contains(loops.moved_inside(middle - 0.01 * left, 1e-4)));
    }
}

// Sums of quadrature over all boxes of a grid are the polygons' own integrals. Exact up to degree 2, but for parts
// below a hundredth of a box, which have one place, and beside corners of holes, where places are drawn together.
TEST(TrimLoops, PlacesIntegrateQuadratics) {
  const TrimLoops loops = octagon_with_a_hole();
  constexpr int kBoxes = 9;
  for (const int most : {4, 9, 16}) {
    double area = 0.0;
    Vec2 first = Vec2::Zero(), second = Vec2::Zero();
    for (int k = 0; k < kBoxes * kBoxes; ++k) {
      const double size = 2.0 / kBoxes;
      const Vec2 low = size * Vec2(k % kBoxes, k / kBoxes), high = low + Vec2::Constant(size);
      const auto places = loops.places_in(low, high, most);
      EXPECT_LE(places.size(), most);
      for (const WeightedPlace& p : places) {
        EXPECT_GT(p.area, 0.0);
        EXPECT_TRUE(loops.contains(p.at));
        EXPECT_TRUE((p.at.array() > low.array()).all() && (p.at.array() < high.array()).all());
        area += p.area, first += p.area * p.at, second += p.area * p.at.cwiseAbs2();
      }
    }
    const double outer = polygon_area(0.8, 8), inner = polygon_area(0.3, 4);
    EXPECT_NEAR(area, outer - inner, 1e-12);
    EXPECT_LT((first - outer * Vec2(1.0, 0.9) + inner * Vec2(1.1, 1.0)).norm(), 1e-12);
    // of a regular polygon about its centre along any axis: A r^2 (2 + cos(2 pi / n)) / 12
    const auto about = [](double r, int n) {
      return polygon_area(r, n) * r * r * (2.0 + std::cos(2.0 * std::numbers::pi / n)) / 12.0;
    };
    const double moment = outer * 1.0 + about(0.8, 8) - inner * 1.21 - about(0.3, 4);
    EXPECT_NEAR(second.x(), moment, 5e-5);
  }
}

TEST(TrimLoops, AWholeBoxHasTheGaussPoints) {
  const TrimLoops loops(Vec2::Zero(), Vec2::Constant(2.0), {{ring({1.0, 1.0}, 0.3, 5, 0.0), true}});
  const auto places = loops.places_in({0.0, 0.0}, {0.2, 0.1}, 4);
  ASSERT_EQ(places.size(), 4u);
  for (const WeightedPlace& p : places) {
    EXPECT_NEAR(std::abs(p.at.x() - 0.1), 0.1 / std::sqrt(3.0), 1e-15);
    EXPECT_NEAR(std::abs(p.at.y() - 0.05), 0.05 / std::sqrt(3.0), 1e-15);
  }
}

TEST(TrimLoops, TellWhichBoxesTheyCut) {
  const TrimLoops loops(Vec2::Zero(), Vec2::Constant(2.0), {{ring({1.0, 1.0}, 0.5, 4, 0.0), true}});
  EXPECT_TRUE(loops.cuts({1.4, 0.9}, {1.6, 1.1}));
  EXPECT_FALSE(loops.cuts({0.9, 0.9}, {1.1, 1.1}));    // within the hole
  EXPECT_FALSE(loops.cuts({1.35, 1.35}, {1.5, 1.5}));  // in the box of an edge, beside it
}

}  // namespace sunder::shell
