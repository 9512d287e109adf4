// Curves as cuts: how they are sampled, and where they meet themselves.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "shell/geometry/plane_curves.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kSpacing = 0.01;

struct Edges {
  double shortest = 1e300, longest = 0.0, sag = 0.0;  // [m]; sag: from the middle of a chord to the curve
};
Edges edges_of(const std::vector<Vec2>& points, const PlaneCurve& curve) {
  const std::vector<Vec2> fine = fine_points(curve, 0.05 * kSpacing);
  Edges e;
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    const double length = (points[k + 1] - points[k]).norm();
    e.shortest = std::min(e.shortest, length), e.longest = std::max(e.longest, length);
    const Vec2 middle = 0.5 * (points[k] + points[k + 1]);
    double nearest = 1e300;
    for (const Vec2& p : fine) nearest = std::min(nearest, (p - middle).norm());
    e.sag = std::max(e.sag, nearest);
  }
  return e;
}

}  // namespace

TEST(CrackPoints, OfACircleCloseExactlyAndStayByTheArc) {
  for (const double radius : {0.5, 1.0, 3.0, 10.0, 40.0}) {  // spacings
    const PlaneCurve circle = circle_curve({0.3, -0.2}, radius * kSpacing);
    const std::vector<Vec2> points = crack_points(circle, kSpacing);
    EXPECT_EQ(points.front(), points.back());
    const Edges e = edges_of(points, circle);
    EXPECT_GE(points.size(), 9u);
    EXPECT_LE(e.longest, kSpacing);
    // a circle of less than eight half spacings still has eight edges
    EXPECT_GE(e.shortest, (radius < 0.7 ? 0.38 : 0.49) * kSpacing) << radius;
    // edges of half a spacing are within a hundredth of the arc where its radius is above three spacings
    if (radius > 3.0) {
      EXPECT_LT(e.sag, 0.0101 * kSpacing) << radius;
    }
    for (const Vec2& p : points) EXPECT_NEAR((p - Vec2(0.3, -0.2)).norm(), radius * kSpacing, 1e-12);
    EXPECT_FALSE(meets_itself(points, 1e-9 * kSpacing));
  }
}

TEST(CrackPoints, OfASpiralAreOnIt) {
  for (const double inner : {0.0, 0.01}) {
    const PlaneCurve spiral = spiral_curve({0.1, 0.1}, inner, 0.08, 3.5);
    const std::vector<Vec2> points = crack_points(spiral, kSpacing);
    const Edges e = edges_of(points, spiral);
    EXPECT_LE(e.longest, kSpacing);
    EXPECT_GE(e.shortest, 0.42 * kSpacing);  // half a spacing along the curve, which winds up at its middle
    EXPECT_NEAR((points.front() - Vec2(0.1, 0.1)).norm(), inner, 1e-15);
    EXPECT_LT((points.back() - Vec2(0.02, 0.1)).norm(), 1e-12);  // half a turn past three
    EXPECT_FALSE(meets_itself(points, 1e-9 * kSpacing));
    for (const Vec2& p : points) {  // r = inner + (outer - inner) angle / (2 pi turns), to whole turns
      const Vec2 d = p - Vec2(0.1, 0.1);
      if (d.norm() < 1e-6) continue;
      const double turns = 3.5 * (d.norm() - inner) / (0.08 - inner), angle = std::atan2(d.y(), d.x());
      EXPECT_NEAR(std::remainder(turns - angle / (2.0 * std::numbers::pi), 1.0), 0.0, 1e-9);
    }
  }
}

TEST(CrackPoints, OfASplineAreThoseOfBernsteinsPolynomial) {
  const std::vector<Vec2> control{{0.0, 0.0}, {0.03, 0.1}, {0.09, -0.04}, {0.12, 0.05}};
  const PlaneCurve cubic = spline_curve(control, 3, false);  // one span: a Bezier curve
  for (const double t : {0.0, 0.2, 0.7, 1.0}) {
    const double s = 1.0 - t;
    const Vec2 exact =
        s * s * s * control[0] + 3.0 * s * s * t * control[1] + 3.0 * s * t * t * control[2] + t * t * t * control[3];
    EXPECT_LT((cubic.at(t) - exact).norm(), 1e-15);
  }
  const std::vector<Vec2> points = crack_points(cubic, kSpacing);
  EXPECT_EQ(points.front(), control.front());
  EXPECT_EQ(points.back(), control.back());
  EXPECT_LE(edges_of(points, cubic).longest, kSpacing);
}

TEST(CrackPoints, OfAClosedSplineGoRoundSmoothly) {
  const std::vector<Vec2> control{{0.0, 0.0}, {0.1, 0.0}, {0.13, 0.09}, {0.02, 0.1}};
  for (const int degree : {2, 3, 4, 5}) {
    const PlaneCurve curve = spline_curve(control, degree, true);
    EXPECT_LT((curve.at(0.0) - curve.at(1.0)).norm(), 1e-15);
    const double e = 1e-6;  // slopes on both sides of where it closes: round-off 1e-16 / e, truncation e
    EXPECT_LT((curve.at(e) - curve.at(0.0) - curve.at(1.0) + curve.at(1.0 - e)).norm() / e, 1e-5);
    const std::vector<Vec2> points = crack_points(curve, kSpacing);
    EXPECT_EQ(points.front(), points.back());
    EXPECT_FALSE(meets_itself(points, 1e-9 * kSpacing));
  }
}

TEST(MeetsItself, FindsTheFirstTwoSegmentsThatCrossTouchOrFoldBack) {
  const auto pair = [](const std::vector<Vec2>& points) {
    const auto hit = meets_itself(points, 1e-9);
    return hit ? std::pair(hit->first, hit->second) : std::pair(-1, -1);
  };
  const std::pair<int, int> none(-1, -1);
  EXPECT_EQ(pair({{0, 0}, {1, 0}}), none);
  EXPECT_EQ(pair({{0, 0}, {1, 0}, {1, 1}, {0, 0}}), none);                             // closed
  EXPECT_EQ(pair({{0, 0}, {2, 0}, {1, 1}, {1, -1}}), std::pair(0, 2));                 // crosses
  EXPECT_EQ(pair({{0, 0}, {2, 0}, {1, 1}, {1, 0}}), std::pair(0, 2));                  // its end lands on itself
  EXPECT_EQ(pair({{0, 0}, {2, 0}, {1, 0}}), std::pair(0, 1));                          // folds back
  EXPECT_EQ(pair({{0, 0}, {1, 0}, {0, 0}}), std::pair(0, 1));                          // closed, of two segments
  EXPECT_EQ(pair({{0, 0}, {1, 0}, {1, 1}, {0, 1e-12}}), std::pair(0, 2));              // all but closed
  EXPECT_EQ(pair({{0, 0}, {2, 0}, {2, 1}, {1, 0}, {1, 1}, {0, 0}}), std::pair(0, 2));  // touches with a corner
  EXPECT_EQ(pair({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 0.1}, {0, 0}}), none);
}

TEST(Thinned, LeavesOutWhatIsWithinTheTolerance) {
  const std::vector<Vec2> corner{{0, 0}, {1, 1e-3}, {2, -1e-3}, {3, 0}, {3, 1}, {3.001, 2}, {3, 3}};
  EXPECT_EQ(thinned(corner, 0.01), (std::vector<Vec2>{{0, 0}, {3, 0}, {3, 3}}));
  EXPECT_EQ(thinned(corner, 1e-6), corner);
  std::vector<Vec2> circle;
  for (int k = 0; k <= 2000; ++k)
    circle.emplace_back(std::cos(k * std::numbers::pi / 1000), std::sin(k * std::numbers::pi / 1000));
  circle.back() = circle.front();
  const std::vector<Vec2> fewer = thinned(circle, 1e-3);
  EXPECT_EQ(fewer.front(), fewer.back());
  EXPECT_LT(fewer.size(), 150u);
  for (std::size_t k = 0; k + 1 < fewer.size(); ++k)  // the sagitta of every chord
    EXPECT_LE(1.0 - (0.5 * (fewer[k] + fewer[k + 1])).norm(), 1.001e-3);
  EXPECT_EQ(thinned({{0, 0}, {1e-5, 0}, {1e-5, 1e-5}, {0, 0}}, 1.0).size(), 4u);  // still goes round something
}
