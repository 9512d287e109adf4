// Parts of a surface in the plane.
#include "shell/meshes/flatten.h"

#include <numeric>

#include <gtest/gtest.h>

#include "tests/shell/triangles.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

std::vector<int> all_triangles(const TriangleMesh& m) {
  std::vector<int> out(m.triangles.size());
  std::iota(out.begin(), out.end(), 0);
  return out;
}

double most_of(const Flat& f) { return *std::max_element(f.most.begin(), f.most.end()); }

// A surface without Gaussian curvature lies flat without stretch, as finely as its triangles are one.
TEST(Flatten, ARolledSheetIsUnrolledExactly) {
  const TriangleMesh m =
      lattice(20, 12, false, [](double u, double v) { return Vec3(std::sin(2.0 * u), v, std::cos(2.0 * u)); }).mesh();
  const auto flat = flatten(m, all_triangles(m));
  ASSERT_TRUE(flat);
  EXPECT_LT(most_of(*flat), 1.02);  // random triangles across a bend are no developable surface
  const TriangleMesh plane =
      lattice(20, 12, false, [](double u, double v) { return Vec3(u, 0.6 * v, 0.3 * u); }).mesh();
  const auto same = flatten(plane, all_triangles(plane));
  ASSERT_TRUE(same);
  EXPECT_LT(most_of(*same), 1.0 + 1e-9);  // round-off of two solutions
}

TEST(Flatten, ThePlaneHasTheAreaOfTheSurfaceAndNothingIsTurnedOver) {
  const TriangleMesh m = lattice(24, 24, false, [](double u, double v) {
                           return Vec3(u, v, 0.5 * (u - 0.5) * (u - 0.5) - 0.4 * (v - 0.5) * (v - 0.5));
                         }).mesh();
  const auto flat = flatten(m, all_triangles(m));
  ASSERT_TRUE(flat);
  double area = 0.0, plane = 0.0;
  for (const int t : flat->triangles) {
    const auto& c = m.triangles[t];
    const Vec2 a = flat->at[flat->local[c[0]]], b = flat->at[flat->local[c[1]]], d = flat->at[flat->local[c[2]]];
    EXPECT_GT(cross(b - a, d - a), 0.0);
    area += m.area(t), plane += 0.5 * cross(b - a, d - a);
  }
  EXPECT_NEAR(plane / area, 1.0, 1e-12);
  EXPECT_LT(most_of(*flat), 1.1);
}

TEST(Flatten, ShapesOfParts) {
  const TriangleMesh sphere = ball(1.0, 4).mesh();
  EXPECT_EQ(shape_of(sphere, all_triangles(sphere)).loops, 0);
  EXPECT_EQ(shape_of(sphere, all_triangles(sphere)).handles, 0);
  std::vector<int> without = all_triangles(sphere);
  without.erase(without.begin());
  EXPECT_EQ(shape_of(sphere, without).loops, 1);
  const TriangleMesh whole = ring().mesh();
  EXPECT_EQ(shape_of(whole, all_triangles(whole)).loops, 0);
  EXPECT_EQ(shape_of(whole, all_triangles(whole)).handles, 2);
}

}  // namespace
