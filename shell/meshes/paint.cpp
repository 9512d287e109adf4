#include "shell/meshes/paint.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "shell/geometry/plane_curves.h"

namespace sunder::shell {
namespace {

constexpr int kMostPaintCells = 4096;  // along a parameter

}  // namespace

template <class Value>
void Paint::add(const std::vector<PlacedTriangle>& triangles, Value&& value) {
  Eigen::AlignedBox2d box;
  for (const PlacedTriangle& t : triangles) {
    Painted& own = triangles_.emplace_back(Painted{t.at, {}});
    for (int k = 0; k < 3; ++k) own.value[k] = value(t, k), box.extend(t.at[k]);
  }
  low_ = box.min();
  cell_ = std::max(std::sqrt(box.sizes().prod() / static_cast<double>(triangles.size())),
                   box.sizes().maxCoeff() / kMostPaintCells);
  for (int d = 0; d < 2; ++d) cells_[d] = static_cast<int>(box.sizes()[d] / cell_) + 1;
  inside_.resize(static_cast<std::size_t>(cells_[0]) * cells_[1]);
  for (std::size_t k = 0; k < triangles_.size(); ++k) {
    Eigen::AlignedBox2d own;
    for (const Vec2& p : triangles_[k].at) own.extend(p);
    const auto low = cell_of(own.min()), high = cell_of(own.max());
    for (int j = low[1]; j <= high[1]; ++j)
      for (int i = low[0]; i <= high[0]; ++i)
        inside_[static_cast<std::size_t>(j) * cells_[0] + i].push_back(static_cast<int>(k));
  }
}

Paint::Paint(const std::vector<PlacedTriangle>& triangles, const std::vector<double>& values) {
  add(triangles, [&](const PlacedTriangle& t, int k) { return values[t.points[k]]; });
}

Paint Paint::of_corners(const std::vector<PlacedTriangle>& triangles, const std::vector<double>& values) {
  Paint out;
  out.add(triangles, [&](const PlacedTriangle& t, int k) { return values[3 * t.triangle + k]; });
  return out;
}

std::array<int, 2> Paint::cell_of(const Vec2& p) const {
  std::array<int, 2> out{};
  for (int d = 0; d < 2; ++d)
    out[d] = static_cast<int>(std::clamp(std::floor((p[d] - low_[d]) / cell_), 0.0, cells_[d] - 1.0));
  return out;
}

// The value at the place of a triangle that is nearest to p, and how far that is.
double Paint::value_near(const Painted& t, const Vec2& p, double& away) const {
  const Vec2 a = t.at[1] - t.at[0], b = t.at[2] - t.at[0], d = p - t.at[0];
  const double area = cross(a, b), v = cross(d, b) / area, w = cross(a, d) / area;
  if (v >= 0.0 && w >= 0.0 && v + w <= 1.0) {
    away = 0.0;
    return (1.0 - v - w) * t.value[0] + v * t.value[1] + w * t.value[2];
  }
  double value = t.value[0];
  away = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    const Vec2 side = t.at[next] - t.at[k];
    const double share = std::clamp((p - t.at[k]).dot(side) / std::max(side.squaredNorm(), 1e-300), 0.0, 1.0);
    const double distance = (p - t.at[k] - share * side).norm();
    if (distance < away) away = distance, value = t.value[k] + share * (t.value[next] - t.value[k]);
  }
  return value;
}

double Paint::at(const Vec2& p) const {
  const std::array<int, 2> cell = cell_of(p);
  double least = std::numeric_limits<double>::infinity(), value = 0.0;
  // Rings of cells about that of p. What is nearest may lie one ring further than what was found first.
  int last = std::max(cells_[0], cells_[1]);
  for (int ring = 0; ring <= last; ++ring) {
    for (int j = cell[1] - ring; j <= cell[1] + ring; ++j)
      for (int i = cell[0] - ring; i <= cell[0] + ring; ++i) {
        if (std::max(std::abs(i - cell[0]), std::abs(j - cell[1])) != ring) continue;
        if (i < 0 || j < 0 || i >= cells_[0] || j >= cells_[1]) continue;
        for (const int k : inside_[static_cast<std::size_t>(j) * cells_[0] + i]) {
          double away = 0.0;
          const double own = value_near(triangles_[k], p, away);
          if (away < least) least = away, value = own;
        }
      }
    if (least == 0.0) break;
    if (std::isfinite(least)) last = std::min(last, static_cast<int>(std::ceil(least / cell_)) + 1);
  }
  return value;
}

}  // namespace sunder::shell
