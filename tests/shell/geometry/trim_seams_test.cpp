// Where borders of trimmed patches run together.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/geometry/builders.h"
#include "shell/geometry/edges.h"
#include "shell/geometry/trim_seams.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr int kAllEdges = kUMin | kUMax | kVMin | kVMax;

Patch sheet(double x0, double x1, double y0, double y1, int nx, int ny) {
  return plate(x1 - x0, y1 - y0, nx, ny, Vec3(0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.0), Quat::Identity(), 2);
}

std::vector<Vec2> closed_ring(const Vec2& centre, double radius, int corners) {
  std::vector<Vec2> out;
  for (int k = 0; k < corners; ++k) {
    const double at = 2.0 * std::numbers::pi * k / corners;
    out.push_back(centre + radius * Vec2(std::cos(at), std::sin(at)));
  }
  out.push_back(out.front());
  return out;
}

struct Two {
  Patch first, second;
  TrimLoops first_trims, second_trims;

  std::vector<Seam> seams(double tolerance = 1e-9, Join join = Join::kClamped) const {
    const auto whole = [](const TrimLoops& trims) { return trims.empty() ? kAllEdges : 0; };
    return find_trim_seams(
        {{&first, &first_trims, whole(first_trims), "first"}, {&second, &second_trims, whole(second_trims), "second"}},
        tolerance, {2, std::vector<Join>(2, join)});
  }
  Vec3 at(const SeamPlace& p, bool of_first) const {
    return of_first ? first.evaluate(p.first).x : second.evaluate(p.second).x;
  }
};

TrimLoops loops(const Patch& p, std::vector<TrimLoop> all) {
  return {Vec2(p.knots_u.begin(), p.knots_v.begin()), Vec2(p.knots_u.end(), p.knots_v.end()), std::move(all)};
}

// A slanted line from (0.4, 0) to (0.6, 1) divides a square; the second patch is finer and begins at x = 0.3.
Two slanted(double shift = 0.0) {
  Two out{sheet(0, 0.8, 0, 1, 8, 10), sheet(0.3, 1, 0, 1, 11, 15), {}, {}};
  out.first_trims = loops(out.first, {{{{0, 0}, {0.4, 0}, {0.6, 1}, {0, 1}, {0, 0}}, false, {}}});
  const double a = 0.1 + shift, b = 0.3 + shift;
  out.second_trims = loops(out.second, {{{{a, 0}, {0.7, 0}, {0.7, 1}, {b, 1}, {a, 0}}, false, {}}});
  return out;
}

}  // namespace

TEST(TrimSeams, BordersThatRunTogetherAreOneSeam) {
  const Two two = slanted();
  const std::vector<Seam> seams = two.seams();
  ASSERT_EQ(seams.size(), 1u);
  const Seam& seam = seams[0];
  EXPECT_TRUE(seam.smooth);
  EXPECT_FALSE(seam.closed);
  EXPECT_EQ(std::minmax(seam.first, seam.second), std::minmax(0, 1));
  EXPECT_NEAR(seam.length, std::hypot(1.0, 0.2), 1e-12);
  double sum = 0.0, before = 0.0;
  const Two turned{two.second, two.first, two.second_trims, two.first_trims};
  const Two& own = seam.first == 0 ? two : turned;
  for (const SeamPlace& p : seam.places) {
    EXPECT_LT((own.at(p, true) - own.at(p, false)).norm(), 1e-12);
    EXPECT_NEAR((p.into_first + p.into_second).norm(), 0.0,
                1e-12);  // both patches are flat, with x and y as parameters
    EXPECT_NEAR(p.into_first.norm(), 1.0, 1e-12);
    EXPECT_NEAR(p.into_first.dot(Vec2(0.2, 1.0)), 0.0, 1e-12);
    EXPECT_GT(p.along, before);
    sum += p.length, before = p.along;
  }
  EXPECT_NEAR(sum, seam.length, 1e-12);
}

TEST(TrimSeams, ADiscFillsAHole) {
  Two two{sheet(0, 1, 0, 1, 10, 10), sheet(0.2, 0.8, 0.2, 0.8, 8, 8), {}, {}};
  two.first_trims = loops(two.first, {{closed_ring({0.5, 0.5}, 0.25, 40), true, {}}});
  two.second_trims = loops(two.second, {{closed_ring({0.3, 0.3}, 0.25, 40), false, {}}});
  const std::vector<Seam> seams = two.seams();
  ASSERT_EQ(seams.size(), 1u);
  EXPECT_TRUE(seams[0].closed);
  EXPECT_NEAR(seams[0].length, 80 * 0.25 * std::sin(std::numbers::pi / 40), 1e-12);
}

// A trimmed flap stands on the edge of a whole plate: the seam is a part of that edge, and a crease.
TEST(TrimSeams, ATrimmedFlapStandsOnAWholeEdge) {
  Two two{sheet(0, 1, 0, 1, 10, 10),
          placed(plate(1, 1, 9, 9, Vec3::Zero(), Quat::Identity()), Vec3(1, 0.5, 0.5),
                 Quat(Eigen::AngleAxisd(-0.5 * std::numbers::pi, Vec3::UnitY()))),
          {},
          {}};
  two.second_trims = loops(two.second, {{{{0, 0.2}, {0, 0.7}, {0.6, 0.5}, {0, 0.2}}, false, {}}});
  const std::vector<Seam> seams = two.seams();
  ASSERT_EQ(seams.size(), 1u);
  EXPECT_NEAR(seams[0].length, 0.5, 1e-12);
  EXPECT_NEAR(seams[0].angle, 0.5 * std::numbers::pi, 1e-9);
  EXPECT_FALSE(seams[0].smooth);
}

TEST(TrimSeams, ThatAreOpenOrBetweenWholePatchesAreLeftToOthers) {
  EXPECT_TRUE(slanted().seams(1e-9, Join::kOpen).empty());
  const Two whole{sheet(0, 0.5, 0, 1, 5, 10), sheet(0.5, 1, 0, 1, 5, 10), {}, {}};
  EXPECT_TRUE(whole.seams().empty());
}

TEST(TrimSeams, BordersThatNearlyMeetAreRefused) {
  try {
    slanted(1e-4).seams();
    FAIL() << "accepted";
  } catch (const Error& e) {
    const std::string text = e.what();
    EXPECT_NE(text.find("nearly meet: they are 9.81e-05 m apart"), std::string::npos) << text;
    EXPECT_NE(text.find("seams.tolerance_m"), std::string::npos) << text;
  }
  EXPECT_EQ(slanted(1e-4).seams(2e-4).size(), 1u);  // what the message advises
  EXPECT_TRUE(slanted(0.05).seams().empty());       // far off
}

TEST(TrimSeams, NormalsOnOppositeSidesAreRefused) {
  Two two = slanted();
  std::swap(two.second.knots_u, two.second.knots_v);
  const Patch before = slanted().second;
  for (int j = 0; j < two.second.rows(); ++j)
    for (int i = 0; i < two.second.columns(); ++i)
      two.second.control_points[j * two.second.columns() + i] = before.control_points[i * before.columns() + j];
  two.second_trims = loops(two.second, {{{{0, 0.1}, {0, 0.7}, {1, 0.7}, {1, 0.3}, {0, 0.1}}, false, {}}});
  try {
    two.seams();
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("normals u x v are on opposite sides"), std::string::npos) << e.what();
  }
}
