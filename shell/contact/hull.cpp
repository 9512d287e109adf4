#include "shell/contact/hull.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "coupler/core/convex_surface.h"

namespace sunder::shell {
namespace {

constexpr int kFew = 24;  // corners; up to here every triple is tried, which takes n^4 / 6 steps

// Calls f(a, b, c) with each triple of corners that may span a plane of the hull.
template <class F>
void each_candidate(const std::vector<Vec3>& corners, F&& f) {
  const int n = static_cast<int>(corners.size());
  if (n > kFew) {
    const Surface hull = convex_surface(corners);
    for (const auto& [i, j, k] : hull.triangles) f(hull.corners[i], hull.corners[j], hull.corners[k]);
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
