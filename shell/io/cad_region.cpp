#include "shell/io/cad_region.h"

#include <algorithm>
#include <cmath>

#include "coupler/core/error.h"

namespace sunder::shell {
namespace {

constexpr int kSamples = 128;  // of a curve, between which it crosses a line once at most
constexpr int kSteps = 60;     // bisections for a crossing

RegionCurve piece(const RegionCurve& curve, double from, double to) {
  return [curve, from, to](double t) { return curve(from + (to - from) * t); };
}

// Stretches of one loop on the kept side, from line to line. A loop that does not cross the line has none.
struct Cut {
  std::vector<RegionLoop> open;
  bool inside = false;  // of a loop that does not cross
};

Cut cut(const RegionLoop& loop, int axis, double value, bool below) {
  const auto kept = [&](const Vec2& p) { return (p[axis] < value) == below; };
  Cut out;
  bool inside = kept(loop[0](0.0));
  const bool started = inside;
  std::vector<RegionLoop> pieces(1);  // the first one ends where the loop first crosses; it goes on the last one
  for (const RegionCurve& curve : loop) {
    double from = 0.0;
    for (int i = 1; i <= kSamples; ++i) {
      double low = (i - 1.0) / kSamples, high = static_cast<double>(i) / kSamples;
      if (kept(curve(high)) == inside) continue;
      for (int k = 0; k < kSteps; ++k) {
        const double middle = 0.5 * (low + high);
        (kept(curve(middle)) == inside ? low : high) = middle;
      }
      const double at = 0.5 * (low + high);
      if (inside)
        pieces.back().push_back(piece(curve, from, at));
      else
        pieces.emplace_back();
      from = at, inside = !inside;
    }
    if (inside) pieces.back().push_back(piece(curve, from, 1.0));
  }
  if (pieces.size() == 1 && started) {
    out.inside = inside;
    return out;
  }
  if (started) {
    pieces.back().insert(pieces.back().end(), pieces.front().begin(), pieces.front().end());
    pieces.front().clear();
  }
  for (RegionLoop& p : pieces)
    if (!p.empty()) out.open.push_back(std::move(p));
  return out;
}

RegionCurve line(const Vec2& a, const Vec2& b) {
  return [a, b](double t) { return Vec2(a + t * (b - a)); };
}

std::vector<Vec2> corners(const RegionLoop& loop) {
  std::vector<Vec2> out;
  for (const RegionCurve& curve : loop)
    for (int i = 0; i < kSamples; ++i) out.push_back(curve(static_cast<double>(i) / kSamples));
  return out;
}

bool holds(const RegionLoop& outline, const Vec2& p) {
  const std::vector<Vec2> c = corners(outline);
  bool inside = false;
  for (std::size_t k = 0; k < c.size(); ++k) {
    const Vec2 &a = c[k], &b = c[(k + 1) % c.size()];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
      inside = !inside;
  }
  return inside;
}

}  // namespace

Eigen::AlignedBox2d box_of(const RegionLoop& loop) {
  Eigen::AlignedBox2d box;
  each_sample(loop, [&](const RegionCurve& curve, double t) { box.extend(curve(t)); });
  for (const RegionCurve& curve : loop)
    for (int axis = 0; axis < 2; ++axis)
      for (const double sign : {-1.0, 1.0}) {
        double best = 0.0;
        for (int i = 0; i < kRegionSamples; ++i) {
          const double t = static_cast<double>(i) / (kRegionSamples - 1);
          if (sign * curve(t)[axis] > sign * curve(best)[axis]) best = t;
        }
        const double step = 1.0 / (kRegionSamples - 1);
        double low = std::max(0.0, best - step), high = std::min(1.0, best + step);
        for (int k = 0; k < kSteps; ++k) {
          const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
          const bool rises = sign * curve(a)[axis] < sign * curve(b)[axis];
          (rises ? low : high) = rises ? a : b;
        }
        box.extend(curve(0.5 * (low + high)));
      }
  return box;
}

double area_of(const RegionLoop& loop) {
  const std::vector<Vec2> c = corners(loop);
  double sum = 0.0;
  for (std::size_t k = 0; k < c.size(); ++k) {
    const Vec2 a = c[k] - c[0], b = c[(k + 1) % c.size()] - c[0];
    sum += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  return sum;
}

Region part_of(const Region& region, int axis, double value, bool below) {
  Region out;
  std::vector<RegionLoop> open;
  for (const RegionLoop& loop : region) {
    Cut c = cut(loop, axis, value, below);
    if (c.inside) out.push_back(loop);
    std::move(c.open.begin(), c.open.end(), std::back_inserter(open));
  }
  // Along the line the part lies on the left as well: upwards on a right side, to the left on an upper side.
  const double way = (axis == 0) == below ? 1.0 : -1.0;
  const auto along = [&](const Vec2& p) { return way * p[1 - axis]; };
  std::vector<char> used(open.size(), 0);
  for (std::size_t first = 0; first < open.size(); ++first) {
    if (used[first]) continue;
    RegionLoop loop;
    for (std::size_t now = first;;) {
      used[now] = 1;
      loop.insert(loop.end(), open[now].begin(), open[now].end());
      const Vec2 end = open[now].back()(1.0);
      std::size_t next = open.size();
      for (std::size_t k = 0; k < open.size(); ++k) {
        const double off = along(open[k].front()(0.0)) - along(end);
        if (off > 0.0 && (next == open.size() || off < along(open[next].front()(0.0)) - along(end))) next = k;
      }
      require(next < open.size() && (next == first || !used[next]),
              "its border does not go round its parameters once; sew or split it in the CAD program");
      loop.push_back(line(end, open[next].front()(0.0)));
      if (next == first) break;
      now = next;
    }
    out.push_back(std::move(loop));
  }
  return out;
}

bool crosses_cleanly(const Region& region, int axis, double value, double tolerance) {
  for (const RegionLoop& loop : region)
    for (const RegionCurve& curve : loop)
      for (const double t : {0.0, 1.0})
        if (std::abs(curve(t)[axis] - value) <= tolerance) return false;
  return true;
}

std::vector<Region> connected(const Region& region) {
  std::vector<Region> out;
  for (const RegionLoop& loop : region)
    if (area_of(loop) > 0.0) out.push_back({loop});
  for (const RegionLoop& loop : region) {
    if (area_of(loop) > 0.0) continue;
    const auto around = std::find_if(out.begin(), out.end(), [&](const Region& part) {
      // one of its points may lie on the border, where another loop touches it
      return std::any_of(loop.begin(), loop.end(), [&](const RegionCurve& c) { return holds(part[0], c(0.5)); });
    });
    require(around != out.end(), "a hole lies outside of the outer border; mend the face in the CAD program");
    around->push_back(loop);
  }
  return out;
}

}  // namespace sunder::shell
