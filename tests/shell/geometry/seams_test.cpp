// Patches whose edges meet: what depends on what, and what is refused.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "coupler/core/error.h"
#include "shell/geometry/builders.h"
#include "shell/geometry/seams.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/stitched.h"

namespace {

using namespace sunder;
using namespace sunder::shell;

Stitches stitches(const std::vector<Patch>& patches, Join join = Join::kClamped, double tolerance = 1e-6) {
  std::vector<const Patch*> all;
  std::vector<std::string> names;
  for (const Patch& p : patches) all.push_back(&p), names.push_back(fmt::format("p{}", names.size()));
  return find_stitches(all, names, tolerance, {patches.size(), std::vector<Join>(patches.size(), join)});
}

std::string refusal(const std::vector<Patch>& patches) {
  try {
    stitches(patches);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

// Weights sum to 1, independent control points depend on nothing, and it all agrees with where the control points are
// at rest.
void expect_sound(const std::vector<Patch>& patches, const Stitches& s, double least) {
  std::set<PatchPoint> dependent;
  for (const Dependence& d : s.points) EXPECT_TRUE(dependent.insert(d.point).second);
  for (const Dependence& d : s.points) {
    double sum = 0.0;
    Vec3 x = Vec3::Zero();
    for (const auto& [p, weight] : d.on) {
      EXPECT_FALSE(dependent.count(p)) << "patch " << p.patch << " point " << p.point;
      EXPECT_GE(weight, least);
      sum += weight, x += weight * patches[p.patch].control_points[p.point];
    }
    EXPECT_NEAR(sum, 1.0, 1e-14);
    EXPECT_LT((x - patches[d.point.patch].control_points[d.point.point]).norm(), 1e-12);
  }
}

bool is_at(const std::vector<Patch>& patches, const PatchPoint& p, const Vec3& x) {
  return (patches[p.patch].control_points[p.point] - x).norm() < 1e-9;
}

std::vector<Patch> cube_corner(int n) {
  std::vector<Patch> out;
  for (int axis = 0; axis < 3; ++axis) {
    Mat3 axes;
    axes.col(0) = Vec3::Unit((axis + 1) % 3), axes.col(1) = Vec3::Unit((axis + 2) % 3), axes.col(2) = Vec3::Unit(axis);
    out.push_back(plate(1.0, 1.0, n + axis, n, 0.5 * (axes.col(0) + axes.col(1)), Quat(axes)));
  }
  return out;
}

}  // namespace

TEST(Seams, MatchingOnesAreFoundSmoothWhereverTheParametersRun) {
  for (int times = 0; times < 4; ++times)
    for (const int degree : {2, 3}) {
      const std::vector<Patch> patches{flat(0, 1, 0, 1, 5, 5, degree), turned(flat(1, 2, 0, 1, 5, 5, degree), times)};
      const Stitches s = stitches(patches);
      ASSERT_EQ(s.seams.size(), 1u);
      EXPECT_TRUE(s.seams[0].smooth);
      EXPECT_TRUE(s.seams[0].crease.empty());
      EXPECT_NEAR(s.seams[0].length, 1.0, 1e-12);
      EXPECT_NEAR(s.seams[0].angle, 0.0, 1e-6);  // of an arc cosine near 1
      expect_sound(patches, s, -1e-12);
      EXPECT_EQ(s.points.size(), 2u * (5 + degree));
      for (const Dependence& d : s.points) EXPECT_EQ(d.on.size(), 2u);  // the point to either side
    }
}

TEST(Seams, OfKnotsThatDoNotMatchFollowWithinAnElementOrTwo) {
  for (const int degree : {2, 3})
    for (const auto& [a, b] : {std::pair{6, 12}, std::pair{6, 9}, std::pair{11, 12}, std::pair{40, 7}}) {
      const std::vector<Patch> patches{flat(0, 1, 0, 1, 5, a, degree), turned(flat(1, 2, 0, 1, 5, b, degree), 2)};
      const Stitches s = stitches(patches);
      ASSERT_EQ(s.seams.size(), 1u);
      expect_sound(patches, s, -1.5);
      const double reach = 2.0 * (degree + 1) / std::min(a, b);
      for (const Dependence& d : s.points)
        for (const auto& [p, weight] : d.on)
          EXPECT_LT(std::abs(patches[p.patch].control_points[p.point].y() -
                             patches[d.point.patch].control_points[d.point.point].y()),
                    reach);
    }
}

// Where the dependent edge has all knots of the independent one it is the same curve, whatever the independent one
// does.
TEST(Seams, FinerSideIsTheCoarserOneWithKnotsInserted) {
  for (const int degree : {2, 3}) {
    const std::vector<Patch> patches{flat(0, 1, 0, 1, 4, 4, degree), flat(1, 2, 0, 1, 4, 12, degree)};
    const Stitches s = stitches(patches, Join::kHinge);
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::vector<std::vector<Vec3>> moved{patches[0].control_points, patches[1].control_points};
    for (Vec3& x : moved[0]) x += Vec3(uniform(random), uniform(random), uniform(random));
    for (const Dependence& d : s.points) {
      ASSERT_EQ(d.point.patch, 1);
      Vec3 x = Vec3::Zero();
      for (const auto& [p, weight] : d.on) x += weight * moved[p.patch][p.point];
      moved[1][d.point.point] = x;
    }
    for (int k = 0; k <= 50; ++k) {
      const Vec3 a = patches[0].evaluate({1.0, k / 50.0}, moved[0]).x,
                 b = patches[1].evaluate({0.0, k / 50.0}, moved[1]).x;
      EXPECT_LT((a - b).norm(), 1e-13);
    }
  }
}

TEST(Seams, OfCylindersAreSmoothAndOfPlatesAtAnAngleCreases) {
  std::vector<Patch> round;
  for (int k = 0; k < 3; ++k)
    round.push_back(placed(cylinder(0.5, 1.0, 2.0 * std::numbers::pi / 3.0, 6 + k, 5 + k), Vec3::Zero(),
                           Quat(Eigen::AngleAxisd(2.0 * std::numbers::pi / 3.0 * k, Vec3::UnitZ()))));
  Stitches s = stitches(round);
  ASSERT_EQ(s.seams.size(), 3u);
  for (const Seam& seam : s.seams) EXPECT_TRUE(seam.smooth);
  expect_sound(round, s, -1.5);
  for (const double degrees : {1.0, 30.0, 90.0, 150.0}) {
    const double angle = degrees * std::numbers::pi / 180.0;
    const Quat bend(Eigen::AngleAxisd(-angle, Vec3::UnitY()));
    const std::vector<Patch> bent{flat(0, 1, 0, 1, 4, 4), placed(flat(0, 1, 0, 1, 4, 5), Vec3(1, 0, 0), bend)};
    s = stitches(bent);
    ASSERT_EQ(s.seams.size(), 1u);
    EXPECT_FALSE(s.seams[0].smooth);
    EXPECT_NEAR(s.seams[0].angle, angle, 1e-6);
    EXPECT_EQ(s.seams[0].crease.size(), 6u);
    double width = 0.0;
    for (const CreasePoint& c : s.seams[0].crease) width += c.width;
    EXPECT_NEAR(width, 1.0, 1e-12);
    expect_sound(bent, s, -1.5);
  }
}

TEST(Seams, FourPatchesAtACornerAgreeOnIt) {
  for (const bool matching : {true, false}) {
    std::vector<Patch> patches;
    for (int k = 0; k < 4; ++k)
      patches.push_back(flat(k % 2, k % 2 + 1, k / 2, k / 2 + 1, matching ? 4 : 4 + k, matching ? 4 : 5 + (2 * k) % 3));
    const Stitches s = stitches(patches);
    EXPECT_EQ(s.seams.size(), 4u);
    expect_sound(patches, s, matching ? -1e-12 : -1.5);
    std::vector<std::vector<std::pair<PatchPoint, double>>> corner;
    for (const Dependence& d : s.points)
      if (is_at(patches, d.point, Vec3(1, 1, 0))) corner.push_back(d.on);
    ASSERT_EQ(corner.size(), 4u);  // all depend on the control points within
    for (const auto& on : corner) {
      ASSERT_EQ(on.size(), matching ? 4u : corner[0].size());
      for (std::size_t k = 0; k < on.size(); ++k) {
        EXPECT_EQ(on[k].first, corner[0][k].first);
        EXPECT_NEAR(on[k].second, corner[0][k].second, 1e-12);
      }
    }
  }
}

TEST(Seams, ThreePatchesAtTheCornerOfACubeShareIt) {
  const std::vector<Patch> patches = cube_corner(4);
  const Stitches s = stitches(patches);
  EXPECT_EQ(s.seams.size(), 3u);
  expect_sound(patches, s, -1.5);
  std::set<PatchPoint> independent;
  int dependent = 0;
  for (const Dependence& d : s.points)
    if (is_at(patches, d.point, Vec3::Zero())) {
      ++dependent;
      ASSERT_EQ(d.on.size(), 1u);
      independent.insert(d.on[0].first);
    }
  EXPECT_EQ(dependent, 2);
  EXPECT_EQ(independent.size(), 1u);
}

TEST(Seams, ThatNearlyMeetAreRefusedWithDistanceAndPlace) {
  const std::string what = refusal({flat(0, 1, 0, 1, 4, 4), flat(1.003, 2, 0, 1, 4, 4)});
  EXPECT_NE(what.find("nearly meet"), std::string::npos) << what;
  EXPECT_NE(what.find("0.003 m apart, at (1, 0, 0)"), std::string::npos) << what;
  EXPECT_NE(what.find("edge U_MAX of shell 'p0' and edge U_MIN of shell 'p1'"), std::string::npos) << what;
  EXPECT_EQ(refusal({flat(0, 1, 0, 1, 4, 4), flat(1.3, 2, 0, 1, 4, 4)}), "");  // far apart: two shells
}

TEST(Seams, OverAPartOfAnEdgeAreRefused) {
  std::string what = refusal({flat(0, 1, 0, 1, 4, 4), flat(1, 2, 0, 0.5, 4, 4)});
  EXPECT_NE(what.find("meet over a part of their length"), std::string::npos) << what;
  EXPECT_NE(what.find("divide the longer one"), std::string::npos) << what;
  // along an arc too, of which chords tell nothing
  const double wide = 2.0, narrow = 1.2;
  const Patch below = placed(cylinder(1.0, 1.0, wide, 6, 4), Vec3(0, 0, -1), Quat::Identity());
  const Quat turn(Eigen::AngleAxisd(0.5 * (wide - narrow), Vec3::UnitZ()));
  what = refusal({below, placed(cylinder(1.0, 1.0, narrow, 6, 4), Vec3::Zero(), turn)});
  EXPECT_NE(what.find("meet over a part of their length"), std::string::npos) << what;
}

TEST(Seams, WithNormalsOnOppositeSidesAreRefused) {
  const Quat over(Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX()));
  const std::string what =
      refusal({flat(0, 1, -0.5, 0.5, 4, 4), placed(flat(1, 2, -0.5, 0.5, 4, 4), Vec3::Zero(), over)});
  EXPECT_NE(what.find("normals u x v are on opposite sides"), std::string::npos) << what;
  EXPECT_NE(what.find("turn one of the patches over"), std::string::npos) << what;
}

TEST(Seams, OfOpenPairsAndPolesAreNone) {
  EXPECT_TRUE(stitches({flat(0, 1, 0, 1, 4, 4), flat(1, 2, 0, 1, 4, 4)}, Join::kOpen).points.empty());
  const double sector = 2.0 * std::numbers::pi / 3.0;
  std::vector<Patch> ball;
  for (int k = 0; k < 3; ++k)
    ball.push_back(placed(sphere(1.0, sector, 0.0, 0.5 * std::numbers::pi, 6, 6), Vec3::Zero(),
                          Quat(Eigen::AngleAxisd(sector * k, Vec3::UnitZ()))));
  const Stitches s = stitches(ball);
  EXPECT_EQ(s.seams.size(), 3u);  // meridians; the edges without length at the pole are none
  expect_sound(ball, s, -1e-12);
}
