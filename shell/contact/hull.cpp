#include "shell/contact/hull.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>
#include <Eigen/Dense>

namespace sunder::shell {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

constexpr int kFew = 24;  // corners; up to here every triple is tried, which takes n^4 / 6 steps

// Calls f(a, b, c) with each triple of corners that may span a plane of the hull.
template <class F>
void each_candidate(const std::vector<Vec3>& corners, F&& f) {
  const int n = static_cast<int>(corners.size());
  if (n > kFew) {
    std::vector<Kernel::Point_3> points;
    for (const Vec3& c : corners) points.emplace_back(c.x(), c.y(), c.z());
    CGAL::Surface_mesh<Kernel::Point_3> hull;
    CGAL::convex_hull_3(points.begin(), points.end(), hull);
    for (const auto face : hull.faces()) {
      std::array<Vec3, 3> at;
      int k = 0;
      for (const auto v : hull.vertices_around_face(hull.halfedge(face)))
        at[k++] = {hull.point(v).x(), hull.point(v).y(), hull.point(v).z()};
      f(at[0], at[1], at[2]);
    }
    return;
  }
  for (int i = 0; i < n; ++i)
    for (int j = i + 1; j < n; ++j)
      for (int k = j + 1; k < n; ++k) f(corners[i], corners[j], corners[k]);
}

}  // namespace

std::vector<Plane> hull_planes(const std::vector<Vec3>& corners) {
  std::vector<Plane> planes;
  double size = 0.0;
  for (const Vec3& c : corners) size = std::max(size, (c - corners[0]).norm());
  const double tolerance = 1e-7 * size;
  each_candidate(corners, [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    Vec3 normal = (b - a).cross(c - a);
    const double length = normal.norm();
    if (length < tolerance * size) return;
    normal /= length;
    double low = 0.0, high = 0.0;
    for (const Vec3& d : corners) {
      const double s = normal.dot(d - a);
      low = std::min(low, s), high = std::max(high, s);
    }
    if (high > tolerance && low < -tolerance) return;
    if (high > tolerance) normal = -normal;
    const double offset = normal.dot(a);
    const bool known = std::any_of(planes.begin(), planes.end(), [&](const Plane& p) {
      return p.normal.dot(normal) > 1.0 - 1e-10 && std::abs(p.offset - offset) < 10.0 * tolerance;
    });
    if (!known) planes.push_back({normal, offset});
  });
  return planes;
}

}  // namespace sunder::shell
