#include "shell/geometry/trim_loops.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>

#include "coupler/core/dense.h"

namespace sunder::shell {
namespace {

constexpr double kOnLoop = 1e-10;    // distance over the size of the domain at which a point is on a loop
constexpr int kMostStrips = 4096;    // of edges
constexpr double kNothing = 1e-10;   // share of a box that counts as none of it
constexpr double kSmallPart = 1e-2;  // share of a box whose part has one place only
constexpr int kTurns = 16;           // of a group of four that are tried
constexpr double kSizeStep = 0.1;    // of a group that is drawn together
constexpr int kSizes = 7;            // steps at most
constexpr int kSearch = 12;          // columns and rows of places that are tried where the centre is outside
constexpr double kInsideBox = 1e-9;  // share of a box by which places stay inside

using Ring = std::vector<Vec2>;  // corners; the last is joined to the first

double signed_area(const Ring& ring) {
  double sum = 0.0;
  for (std::size_t k = 0; k < ring.size(); ++k) sum += cross(ring[k] - ring[0], ring[(k + 1) % ring.size()] - ring[0]);
  return 0.5 * sum;
}

// The part of a ring where normal . p <= offset (Sutherland and Hodgman 1974). A part in several regions is joined by
// edges that are run in both directions and enclose nothing.
Ring clipped(const Ring& ring, const Vec2& normal, double offset) {
  Ring out;
  for (std::size_t k = 0; k < ring.size(); ++k) {
    const Vec2 &a = ring[k], &b = ring[(k + 1) % ring.size()];
    const double from = normal.dot(a) - offset, to = normal.dot(b) - offset;
    if (from <= 0.0) out.push_back(a);
    if ((from < 0.0 && to > 0.0) || (from > 0.0 && to < 0.0)) out.push_back(a + from / (from - to) * (b - a));
  }
  return out;
}

// A region as rings whose signed areas add up: holes are clockwise.
using Region = std::vector<Ring>;

Region clipped(const Region& region, const Vec2& normal, double offset) {
  Region out;
  for (const Ring& ring : region)
    if (Ring part = clipped(ring, normal, offset); part.size() > 2) out.push_back(std::move(part));
  return out;
}

struct Moments {
  double area = 0.0;
  Vec2 centre = Vec2::Zero();
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();  // mean of (p - centre)(p - centre)^T
};

Moments moments_of(const Region& region, const Vec2& origin) {
  Moments m;
  Vec2 first = Vec2::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  for (const Ring& ring : region)
    for (std::size_t k = 0; k < ring.size(); ++k) {  // triangles from the origin
      const Vec2 a = ring[k] - origin, b = ring[(k + 1) % ring.size()] - origin, sum = a + b;
      const double area = 0.5 * cross(a, b);
      m.area += area, first += area / 3.0 * sum;
      second += area / 12.0 * (a * a.transpose() + b * b.transpose() + sum * sum.transpose());
    }
  if (m.area == 0.0) return m;
  m.centre = first / m.area;
  m.spread = second / m.area - m.centre * m.centre.transpose();
  m.centre += origin;
  return m;
}

// Four places of equal area with the mean and the spread of the region. Along both principal axes they stand one
// standard deviation off; a turn of the four in the coordinates that make the spread a unit changes neither.
// `size` below 1 draws them together, beside a corner of a hole, which leaves no other room.
std::vector<WeightedPlace> four_places(const Moments& m, double turn, double size) {
  const PlaneEigenpairs axes = plane_eigenpairs(m.spread);
  const Eigen::Matrix2d root =
      axes.vectors * axes.values.cwiseMax(0.0).cwiseSqrt().asDiagonal() * axes.vectors.transpose();
  std::vector<WeightedPlace> out;
  for (int k = 0; k < 4; ++k) {
    const double angle = turn + std::numbers::pi * (0.25 + 0.5 * k);
    out.push_back(
        {m.centre + root * (size * std::numbers::sqrt2 * Vec2(std::cos(angle), std::sin(angle))), 0.25 * m.area});
  }
  return out;
}

}  // namespace

TrimLoops::TrimLoops(const Vec2& low, const Vec2& high, std::vector<TrimLoop> loops)
    : low_(low), high_(high), tolerance_(kOnLoop * (high - low).norm()), loops_(std::move(loops)) {
  std::size_t count = 0;
  for (TrimLoop& loop : loops_) {
    const double area = signed_area(Ring(loop.points.begin(), loop.points.end() - 1));
    if ((area < 0.0) != loop.hole) std::reverse(loop.points.begin(), loop.points.end());
    outlined_ = outlined_ || !loop.hole;
    count += loop.points.size();
  }
  strips_.resize(std::clamp(static_cast<int>(count), 1, kMostStrips));
  strip_ = (high.y() - low.y()) / static_cast<double>(strips_.size());
  for (const TrimLoop& loop : loops_)
    for (std::size_t k = 0; k + 1 < loop.points.size(); ++k) {
      const Vec2 &a = loop.points[k], &b = loop.points[k + 1];
      const int first = strip_of(std::min(a.y(), b.y()) - tolerance_),
                last = strip_of(std::max(a.y(), b.y()) + tolerance_);
      for (int s = first; s <= last; ++s) strips_[s].push_back({a, b});
    }
}

int TrimLoops::strip_of(double y) const {
  return std::clamp(static_cast<int>(std::floor((y - low_.y()) / strip_)), 0, static_cast<int>(strips_.size()) - 1);
}

bool TrimLoops::contains(const Vec2& p) const {
  bool inside = !outlined_;
  for (const Edge& e : strips_[strip_of(p.y())]) {
    const Vec2 d = e.b - e.a;
    const double along = std::clamp((p - e.a).dot(d) / d.squaredNorm(), 0.0, 1.0);
    if ((p - e.a - along * d).norm() <= tolerance_) return true;
    if ((e.a.y() > p.y()) != (e.b.y() > p.y()) && p.x() < e.a.x() + (p.y() - e.a.y()) / d.y() * d.x()) inside = !inside;
  }
  return inside;
}

Vec2 TrimLoops::moved_inside(const Vec2& p, double depth) const {
  if (contains(p)) return p;
  Vec2 best = p, inwards = Vec2::Zero();
  double nearest = 1e300;
  for (const TrimLoop& loop : loops_)
    for (std::size_t k = 0; k + 1 < loop.points.size(); ++k) {
      const Vec2 &a = loop.points[k], d = loop.points[k + 1] - a;
      const Vec2 foot = a + std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) * d;
      const double away = (p - foot).squaredNorm();
      if (away < nearest) nearest = away, best = foot, inwards = (foot - p).normalized();
    }
  return best + depth * inwards;
}

double TrimLoops::area() const {
  double sum = outlined_ ? 0.0 : (high_ - low_).prod();
  for (const TrimLoop& loop : loops_) sum += signed_area(Ring(loop.points.begin(), loop.points.end() - 1));
  return sum;
}

bool TrimLoops::cuts(const Vec2& low, const Vec2& high) const {
  const Vec2 pad = Vec2::Constant(tolerance_), from = low - pad, to = high + pad;
  for (int s = strip_of(from.y()); s <= strip_of(to.y()); ++s)
    for (const Edge& e : strips_[s]) {
      if (((e.a.cwiseMax(e.b)).array() < from.array()).any() || ((e.a.cwiseMin(e.b)).array() > to.array()).any())
        continue;
      const Vec2 d = e.b - e.a;
      int left = 0;
      for (const Vec2& corner : {from, Vec2(to.x(), from.y()), to, Vec2(from.x(), to.y())})
        left += cross(d, corner - e.a) > 0.0;
      if (left != 0 && left != 4) return true;
    }
  return false;
}

std::vector<WeightedPlace> TrimLoops::places_in(const Vec2& low, const Vec2& high, int most) const {
  const double whole = (high - low).prod();
  Region region;
  if (!outlined_) region.push_back({low, {high.x(), low.y()}, high, {low.x(), high.y()}});
  for (const TrimLoop& loop : loops_) {
    Region part = {Ring(loop.points.begin(), loop.points.end() - 1)};
    for (int d = 0; d < 2; ++d) part = clipped(clipped(part, Vec2::Unit(d), high[d]), -Vec2::Unit(d), -low[d]);
    region.insert(region.end(), part.begin(), part.end());
  }
  std::vector<WeightedPlace> out;
  const Vec2 pad = kInsideBox * (high - low);
  const auto fits = [&](const Vec2& p) {
    return (p.array() >= (low + pad).array()).all() && (p.array() <= (high - pad).array()).all() && contains(p);
  };
  const auto one_place = [&](const Moments& m) {
    Vec2 best = m.centre;
    double nearest = fits(m.centre) ? 0.0 : 1e300;
    for (int k = 0; k < kSearch * kSearch && nearest > 0.0; ++k) {
      const int column = k % kSearch, row = k / kSearch;
      const Vec2 p = low + (high - low).cwiseProduct(Vec2(column + 0.5, row + 0.5) / kSearch);
      const double away = (p - m.centre).squaredNorm();
      if (away < nearest && fits(p)) nearest = away, best = p;
    }
    if (nearest == 1e300) best = m.centre.cwiseMax(low + pad).cwiseMin(high - pad);  // a sliver that bends
    out.push_back({best, m.area});
  };
  const auto place = [&](auto&& self, const Region& part, int groups) -> void {
    const Moments m = moments_of(part, 0.5 * (low + high));
    if (m.area <= kNothing * whole) return;
    if (m.area <= kSmallPart * whole) return one_place(m);
    if (groups > 1) {
      const PlaneEigenpairs axes = plane_eigenpairs(m.spread);
      const Vec2 across = axes.vectors.col(1);
      self(self, clipped(part, across, across.dot(m.centre)), groups / 2);
      self(self, clipped(part, -across, -across.dot(m.centre)), groups / 2);
      return;
    }
    for (int smaller = 0; smaller <= kSizes; ++smaller)
      for (int k = 0; k < kTurns; ++k) {
        const double size = 1.0 - smaller * kSizeStep;
        const std::vector<WeightedPlace> four = four_places(m, 0.5 * std::numbers::pi * k / kTurns, size);
        if (!std::all_of(four.begin(), four.end(), [&](const WeightedPlace& p) { return fits(p.at); })) continue;
        out.insert(out.end(), four.begin(), four.end());
        return;
      }
    one_place(m);
  };
  place(place, region, std::max(1, most / 4));
  return out;
}

}  // namespace sunder::shell
