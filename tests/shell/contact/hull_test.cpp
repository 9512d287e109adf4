#include "shell/contact/hull.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sunder::shell {
namespace {

// Points of a grid on the faces of the unit cube, `n` to an edge.
std::vector<Vec3> on_cube(int n) {
  std::vector<Vec3> out;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k)
        if (std::min({i, j, k}) == 0 || std::max({i, j, k}) == n - 1)
          out.push_back(Vec3(i, j, k) / static_cast<double>(n - 1));
  return out;
}

TEST(HullPlanes, OfACubeAreSixHoweverManyPointsItHas) {
  for (const int n : {2, 3, 5}) {  // 8 points are tried by threes; 26 and 98 go to CGAL
    const std::vector<Plane> planes = hull_planes(on_cube(n));
    ASSERT_EQ(planes.size(), 6U) << n;
    for (const Plane& p : planes) {
      EXPECT_NEAR(p.normal.cwiseAbs().maxCoeff(), 1.0, 1e-14);
      EXPECT_NEAR(p.offset, p.normal.sum() > 0.0 ? 1.0 : 0.0, 1e-14);
    }
  }
}

TEST(HullPlanes, OfManyPointsInAPlaneBoundNothing) {
  std::vector<Vec3> flat;
  for (int k = 0; k < 36; ++k) flat.emplace_back(k % 6, k / 6, 0.0);
  EXPECT_TRUE(hull_planes(flat).empty());
}

}  // namespace
}  // namespace sunder::shell
