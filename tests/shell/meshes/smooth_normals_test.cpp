// Normals of smooth surfaces from their triangles.
#include "shell/meshes/smooth_normals.h"

#include <numeric>

#include <gtest/gtest.h>

#include "tests/shell/triangles.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

double worst_angle(const TriangleMesh& m, const std::function<Vec3(const Vec3&)>& exact) {
  std::vector<int> all(m.triangles.size());
  std::iota(all.begin(), all.end(), 0);
  const Flat f = *flatten(m, all);
  const std::vector<Vec3> normals = smooth_normals(m, f);
  double most = 0.0;
  for (std::size_t k = 0; k < normals.size(); ++k)
    most = std::max(most, normals[k].cross(exact(m.points[f.points[k]])).norm());
  return most;
}

// The mean of triangles' normals would be off by as much as half of the angle between triangles at a border.
TEST(SmoothNormals, OfARollAreThoseOfTheCylinderUpToTheBorder) {
  const auto roll = [](int n) {
    return lattice(n, n, false, [](double u, double v) { return Vec3(std::sin(u), v, std::cos(u)); }).mesh();
  };
  const auto outward = [](const Vec3& x) { return Vec3(x.x(), 0.0, x.z()); };
  const double coarse = worst_angle(roll(8), outward), fine = worst_angle(roll(16), outward);
  EXPECT_LT(coarse, 2e-3);         // the mean of triangles' normals: 0.05
  EXPECT_LT(fine, 0.25 * coarse);  // second order at least
}

TEST(SmoothNormals, OfFewPointsAreTheMeanOfTheirTriangles) {
  const TriangleMesh m = make_triangle_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{{0, 1, 2}, 1}}, 0.0, "line");
  EXPECT_LT(worst_angle(m, [](const Vec3&) { return Vec3(0, 0, 1); }), 1e-12);
}

}  // namespace
