#include "coupler/core/convex_surface.h"

#include <random>

#include <gtest/gtest.h>

namespace sunder {
namespace {

TEST(ConvexSurface, OfABoxAndPointsInsideIsTheBox) {
  std::vector<Vec3> points;
  for (int k = 0; k < 8; ++k) points.emplace_back(k & 1 ? 2.0 : 0.0, k & 2 ? 3.0 : 0.0, k & 4 ? 4.0 : 0.0);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(0.01, 0.99);
  for (int i = 0; i < 50; ++i) points.emplace_back(2.0 * share(random), 3.0 * share(random), 4.0 * share(random));
  const Surface s = convex_surface(points);
  EXPECT_EQ(s.corners.size(), 8u);
  EXPECT_EQ(s.triangles.size(), 12u);
  EXPECT_DOUBLE_EQ(enclosed_volume(s), 24.0);
}

TEST(ConvexSurface, DoesNotDependOnTheOrderOfPoints) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::vector<Vec3> points;
  for (int i = 0; i < 40; ++i) points.emplace_back(normal(random), normal(random), normal(random));
  const Surface first = convex_surface(points);
  std::shuffle(points.begin(), points.end(), random);
  const Surface second = convex_surface(points);
  EXPECT_EQ(first.corners, second.corners);
  EXPECT_EQ(first.triangles, second.triangles);
}

TEST(ConvexSurface, OfFlatPointsHasNoTriangles) {
  EXPECT_TRUE(convex_surface({{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}).triangles.empty());
  EXPECT_TRUE(convex_surface({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}}).triangles.empty());
}

}  // namespace
}  // namespace sunder
