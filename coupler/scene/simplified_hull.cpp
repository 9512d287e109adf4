// Picks corners of a convex hull, so that few of them hold nearly all of its volume.
#include <algorithm>
#include <cmath>

#include <Eigen/Dense>
#include <Eigen/Geometry>

#include "coupler/core/principal_axes.h"
#include "coupler/scene/mesh.h"

namespace sunder::scene {
namespace {

template <class Distance>
std::size_t farthest(const std::vector<Vec3>& points, const Distance& distance) {
  std::size_t best = 0;
  double most = -INFINITY;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (const double d = distance(points[i]); d > most) most = d, best = i;
  return best;
}

// The points as those of a body that is as wide along all axes: shares of the volume stay.
std::vector<Vec3> rounded(const std::vector<Vec3>& points) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / static_cast<double>(points.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& p : points) spread += (p - mean) * (p - mean).transpose() / static_cast<double>(points.size());
  const auto [squares, frame] = principal_axes(spread);  // mean squares of the coordinates along its axes
  std::vector<Vec3> out;
  for (const Vec3& p : points) out.push_back((frame.transpose() * (p - mean)).cwiseQuotient(squares.cwiseSqrt()));
  return out;
}

// Plane of each triangle: unit normal and offset.
std::vector<std::pair<Vec3, double>> planes_of(const Surface& s) {
  std::vector<std::pair<Vec3, double>> out;
  for (const auto& [i, j, k] : s.triangles) {
    const Vec3& a = s.corners[i];
    const Vec3 normal = (s.corners[j] - a).cross(s.corners[k] - a).stableNormalized();
    out.emplace_back(normal, normal.dot(a));
  }
  return out;
}

}  // namespace

Hull simplified_hull(const Surface& hull, int most_corners) {
  const std::vector<Vec3> all = rounded(hull.corners);
  // Four corners as far apart as they can be, one after the other. Then the corner farthest outside, again and again.
  std::vector<std::size_t> kept{0};
  const auto from_first = [&](std::size_t i) -> Vec3 { return all[i] - all[kept[0]]; };
  kept.push_back(farthest(all, [&](const Vec3& p) { return (p - all[kept[0]]).squaredNorm(); }));
  const Vec3 along = from_first(kept[1]);
  kept.push_back(farthest(all, [&](const Vec3& p) { return along.cross(p - all[kept[0]]).squaredNorm(); }));
  const Vec3 normal = along.cross(from_first(kept[2]));
  kept.push_back(farthest(all, [&](const Vec3& p) { return std::abs(normal.dot(p - all[kept[0]])); }));
  while (static_cast<int>(kept.size()) < most_corners) {
    std::vector<Vec3> inner;
    for (const std::size_t i : kept) inner.push_back(all[i]);
    const auto planes = planes_of(convex_surface(inner));
    const auto outside = [&](const Vec3& p) {
      double most = -INFINITY;
      for (const auto& [n, offset] : planes) most = std::max(most, n.dot(p) - offset);
      return most;
    };
    const std::size_t next = farthest(all, outside);
    if (outside(all[next]) <= 0.0) break;
    kept.push_back(next);
  }
  std::vector<Vec3> points;
  for (const std::size_t i : kept) points.push_back(hull.corners[i]);
  const Surface inner = convex_surface(points);
  const double whole = enclosed_volume(hull), share = enclosed_volume(inner) / whole;
  if (share < 1.0 - kMostLost)
    throw Error(
        Exit::kBadInput, "bad_mesh",
        fmt::format("has a convex part of {} corners, and {} of them hold {:.1f} % of its volume, less than "
                    "{:g} %; thin its points out to {}",
                    hull.corners.size(), inner.corners.size(), 100.0 * share, 100.0 * (1.0 - kMostLost), most_corners));
  return {inner.corners, share * whole};
}

}  // namespace sunder::scene
