#include "shell/geometry/plane_curves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

namespace sunder::shell {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kLongest = 0.9;  // edge length [spacings]; insertion would halve a longer one
constexpr double kMargin = 0.9;  // share of the edge length that kSag allows: rounding to whole edges makes them longer
constexpr int kFine = 16;        // fine points per spacing
constexpr int kFewest = 256, kMost = 1 << 19;  // number of fine points
constexpr int kHighestSpline = 5;              // highest degree

Vec2 nearest(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  return a + std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0) * d;
}

// Tests whether segments ab and cd meet within `tolerance`; `at` receives the point.
bool meet(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d, double tolerance, Vec2& at) {
  const double slope = cross(b - a, d - c);
  if (slope != 0.0) {
    const double s = cross(c - a, d - c) / slope, t = cross(c - a, b - a) / slope;
    at = a + s * (b - a);
    if (s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0) return true;
  }
  for (const auto& [p, q, r] : {std::array{a, c, d}, std::array{b, c, d}, std::array{c, a, b}, std::array{d, a, b}})
    if ((p - nearest(p, q, r)).norm() <= tolerance) {
      at = p;
      return true;
    }
  return false;
}

}  // namespace

PlaneCurve circle_curve(const Vec2& centre, double radius) {
  return {[=](double t) { return Vec2(centre + radius * Vec2(std::cos(kTurn * t), std::sin(kTurn * t))); },
          kTurn * radius, true};
}

PlaneCurve spiral_curve(const Vec2& centre, double inner, double outer, double turns) {
  // t is nearly proportional to arc length: the square of the radius grows linearly with t.
  return {[=](double t) {
            const double r = std::sqrt(inner * inner + t * (outer * outer - inner * inner));
            const double angle = kTurn * turns * (r - inner) / (outer - inner);
            return Vec2(centre + r * Vec2(std::cos(angle), std::sin(angle)));
          },
          kTurn * turns * 0.5 * (inner + outer) + outer - inner, false};
}

PlaneCurve spline_curve(const std::vector<Vec2>& points, int degree, bool closed) {
  const int count = static_cast<int>(points.size()), spans = closed ? count : count - degree;
  PlaneCurve curve;
  curve.closed = closed;
  for (int i = 0; i + 1 < count; ++i) curve.length += (points[i + 1] - points[i]).norm();
  if (closed) curve.length += (points.front() - points.back()).norm();
  curve.at = [=](double t) {  // de Boor's algorithm
    const double u = t * spans;
    const int span = std::clamp(static_cast<int>(u), 0, spans - 1);
    const auto knot = [&](int i) { return closed ? i - degree : std::clamp(i - degree, 0, spans); };
    std::array<Vec2, kHighestSpline + 1> d;
    for (int j = 0; j <= degree; ++j) d[j] = points[(span + j) % count];
    for (int r = 1; r <= degree; ++r)
      for (int j = degree; j >= r; --j) {
        const int low = knot(span + j), high = knot(span + j + degree - r + 1);
        const double share = (u - low) / (high - low);
        d[j] = (1.0 - share) * d[j - 1] + share * d[j];
      }
    return d[degree];
  };
  return curve;
}

std::vector<Vec2> fine_points(const PlaneCurve& curve, double spacing) {
  const double wanted = std::clamp(kFine * curve.length / spacing, 1.0 * kFewest, 1.0 * kMost);
  // a multiple of 4, so that the quarters of a circle are included
  const int pieces = 4 * static_cast<int>(std::ceil(0.25 * wanted));
  std::vector<Vec2> points(pieces + 1);
  for (int i = 0; i <= pieces; ++i) points[i] = curve.at(static_cast<double>(i) / pieces);
  if (curve.closed) points.back() = points.front();
  return points;
}

std::vector<double> crack_parameters(const PlaneCurve& curve, double spacing) {
  const std::vector<Vec2> p = fine_points(curve, spacing);
  const int pieces = static_cast<int>(p.size()) - 1;
  std::vector<double> bend(p.size(), 0.0);  // curvature [1/m]
  for (int i = curve.closed ? 0 : 1; i < pieces; ++i) {
    const Vec2 in = p[i] - p[i > 0 ? i - 1 : pieces - 1], out = p[i + 1] - p[i];
    const double length = 0.5 * (in.norm() + out.norm());
    if (length > 0.0) bend[i] = std::abs(std::atan2(cross(in, out), in.dot(out))) / length;
  }
  if (curve.closed) bend[pieces] = bend[0];
  std::vector<double> edges(p.size(), 0.0);  // integral of 1 / (edge length) from the start to this point
  for (int i = 1; i <= pieces; ++i) {
    const double radius = 1.0 / std::max({bend[i - 1], bend[i], 1e-9 / spacing});
    const double edge =
        std::clamp(kMargin * std::sqrt(8.0 * kSag * spacing * radius), kShortestEdge * spacing, kLongest * spacing);
    edges[i] = edges[i - 1] + (p[i] - p[i - 1]).norm() / edge;
  }
  const int count = std::max(curve.closed ? 8 : 1, static_cast<int>(edges.back() + 1e-9));
  std::vector<double> out{0.0};
  int i = 1;
  for (int k = 1; k < count; ++k) {
    const double at = edges.back() * k / count;
    while (i < pieces && edges[i] < at) ++i;
    const double share = (at - edges[i - 1]) / std::max(edges[i] - edges[i - 1], 1e-300);
    out.push_back((i - 1 + share) / pieces);
  }
  out.push_back(1.0);
  return out;
}

std::vector<Vec2> crack_points(const PlaneCurve& curve, double spacing) {
  std::vector<Vec2> out;
  for (const double t : crack_parameters(curve, spacing)) out.push_back(curve.at(t));
  if (curve.closed) out.back() = out.front();
  return out;
}

std::vector<Vec2> thinned(const std::vector<Vec2>& p, double tolerance) {
  const std::size_t last = p.size() - 1;
  std::vector<char> stays(p.size(), 0);
  stays.front() = stays.back() = 1;
  std::vector<std::pair<std::size_t, std::size_t>> open{{0, last}};
  int corners = p.front() == p.back() ? 0 : 2;  // a closed polyline needs two corners besides its starting point
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    std::size_t furthest = a;
    double most = corners < 2 ? -1.0 : tolerance;
    for (std::size_t k = a + 1; k < b; ++k)
      if (const double away = (p[k] - nearest(p[k], p[a], p[b])).norm(); away > most) most = away, furthest = k;
    if (furthest == a) continue;
    stays[furthest] = 1, ++corners;
    open.push_back({furthest, b}), open.push_back({a, furthest});
  }
  std::vector<Vec2> out;
  for (std::size_t k = 0; k <= last; ++k)
    if (stays[k]) out.push_back(p[k]);
  return out;
}

std::optional<Vec2> segments_touch(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d, double tolerance) {
  Vec2 at;
  if (!meet(a, b, c, d, tolerance, at)) return std::nullopt;
  return at;
}

std::optional<Meeting> meets_itself(const std::vector<Vec2>& p, double tolerance) {
  const int count = static_cast<int>(p.size()) - 1;
  const bool closed = count > 1 && p.front() == p.back();
  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), 0);
  const auto left = [&](int k) { return std::min(p[k].x(), p[k + 1].x()) - tolerance; };
  const auto right = [&](int k) { return std::max(p[k].x(), p[k + 1].x()) + tolerance; };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return left(a) != left(b) ? left(a) < left(b) : a < b; });
  std::optional<Meeting> found;
  for (int a = 0; a < count; ++a)
    for (int b = a + 1; b < count && left(order[b]) <= right(order[a]); ++b) {
      const int i = std::min(order[a], order[b]), j = std::max(order[a], order[b]);
      if (found && std::pair(i, j) > std::pair(found->first, found->second)) continue;
      if (std::max(p[i].y(), p[i + 1].y()) + tolerance < std::min(p[j].y(), p[j + 1].y()) ||
          std::max(p[j].y(), p[j + 1].y()) + tolerance < std::min(p[i].y(), p[i + 1].y()))
        continue;
      Vec2 at;
      bool hit = false;
      // Neighbours share an end. They meet elsewhere only where one folds back on the other.
      const auto folds = [&](const Vec2& far, const Vec2& shared, const Vec2& other) {
        if ((far - nearest(far, shared, other)).norm() <= tolerance) at = far, hit = true;
      };
      const bool follows = j == i + 1, around = closed && i == 0 && j == count - 1;
      if (follows) folds(p[i], p[j], p[j + 1]), folds(p[j + 1], p[j], p[i]);
      if (around) folds(p[1], p[0], p[j]), folds(p[j], p[0], p[1]);
      if (!follows && !around) hit = meet(p[i], p[i + 1], p[j], p[j + 1], tolerance, at);
      if (hit) found = Meeting{i, j, at};
    }
  return found;
}

}  // namespace sunder::shell
