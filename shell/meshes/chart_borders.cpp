#include "shell/meshes/chart_borders.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>

#include <Eigen/Geometry>

#include "coupler/core/error.h"
#include "shell/meshes/surface_fit.h"

namespace sunder::shell {
namespace {

constexpr double kCorner = 25.0 * std::numbers::pi / 180.0;  // a border that turns by more has a corner there
constexpr double kSmoothedOver = 0.75;                       // elements over which a border is smoothed
constexpr double kSmoothedEdges = 2.0;                       // edges of the mesh, where those are longer
constexpr double kPlacesApart = 0.25;                        // of points of curves [elements]
constexpr int kFewestPlaces = 8;                             // of a border
constexpr int kMostSmoothing = 4000;                         // rounds

using Creases = std::vector<std::array<char, 3>>;

// A border edge of a triangle, with its chart on the left.
struct HalfEdge {
  int triangle = 0, edge = 0;
};

class Walker {
 public:
  Walker(const TriangleMesh& m, const Creases& creases, const std::vector<int>& chart)
      : m_(m), creases_(creases), chart_(chart), edges_at_(m.points.size(), 0) {
    for (std::size_t t = 0; t < m.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k)
        if (const HalfEdge h{static_cast<int>(t), k}; is_border(h) && (across(h) < 0 || across(h) > h.triangle))
          ++edges_at_[from(h)], ++edges_at_[to(h)];
  }

  int from(const HalfEdge& h) const { return m_.triangles[h.triangle][h.edge]; }
  int to(const HalfEdge& h) const { return m_.triangles[h.triangle][(h.edge + 1) % 3]; }
  int across(const HalfEdge& h) const { return m_.beside[h.triangle][h.edge]; }
  int other(const HalfEdge& h) const { return across(h) < 0 ? -1 : chart_[across(h)]; }
  bool is_border(const HalfEdge& h) const { return across(h) < 0 || chart_[across(h)] != chart_[h.triangle]; }
  bool is_crease(const HalfEdge& h) const { return across(h) < 0 || creases_[h.triangle][h.edge] != 0; }

  // The next border edge of the chart, about the end of this one.
  HalfEdge next(HalfEdge h) const {
    const int pivot = to(h);
    h.edge = (h.edge + 1) % 3;
    while (!is_border(h)) {
      const int t = across(h);
      int k = 0;
      while (m_.triangles[t][k] != pivot) ++k;
      h = {t, k};
    }
    return h;
  }
  // Whether a chain ends between two edges that follow each other.
  bool breaks(const HalfEdge& a, const HalfEdge& b) const {
    return edges_at_[from(b)] != 2 || other(a) != other(b) || is_crease(a) != is_crease(b);
  }

 private:
  const TriangleMesh& m_;
  const Creases& creases_;
  const std::vector<int>& chart_;
  std::vector<int> edges_at_;  // border edges at each point
};

double polyline_length(const std::vector<Vec2>& p) {
  double sum = 0.0;
  for (std::size_t k = 1; k < p.size(); ++k) sum += (p[k] - p[k - 1]).norm();
  return sum;
}

// `count` pieces of equal length.
std::vector<Vec2> resampled(const std::vector<Vec2>& p, int count) {
  const double whole = polyline_length(p);
  std::vector<Vec2> out{p.front()};
  double before = 0.0;
  std::size_t k = 1;
  for (int i = 1; i < count; ++i) {
    const double wanted = whole * i / count;
    while (k + 1 < p.size() && before + (p[k] - p[k - 1]).norm() < wanted) before += (p[k] - p[k - 1]).norm(), ++k;
    const double step = (p[k] - p[k - 1]).norm();
    out.push_back(p[k - 1] + std::clamp((wanted - before) / std::max(step, 1e-300), 0.0, 1.0) * (p[k] - p[k - 1]));
  }
  out.push_back(p.back());
  return out;
}

void smooth(std::vector<Vec2>& p, bool closed, int rounds) {
  const std::size_t n = p.size() - 1;
  for (int round = 0; round < rounds; ++round) {
    const std::vector<Vec2> from = p;
    for (std::size_t k = closed ? 0 : 1; k < n; ++k)
      p[k] = 0.25 * from[(k + n - 1) % n] + 0.5 * from[k] + 0.25 * from[k + 1];
    if (closed) p[n] = p[0];
  }
}

// Numbers of the chain's points where it has a corner; both ends of an open chain are such.
std::vector<std::size_t> corners_of(const TriangleMesh& m, const BorderChain& c) {
  std::vector<std::size_t> out;
  const std::size_t n = c.points.size() - 1;
  for (std::size_t k = 0; k <= n; ++k) {
    if (!c.closed && (k == 0 || k == n)) {
      out.push_back(k);
      continue;
    }
    if (c.closed && k == n) continue;
    const Vec3 in = m.points[c.points[k]] - m.points[c.points[(k + n - 1) % n]],
               then = m.points[c.points[k + 1]] - m.points[c.points[k]];
    if (std::atan2(in.cross(then).norm(), in.dot(then)) > kCorner) out.push_back(k);
  }
  return out;
}

}  // namespace

ChartBorders borders_of(const TriangleMesh& m, const Creases& creases, const std::vector<int>& chart, int charts) {
  const Walker walk(m, creases, chart);
  ChartBorders out;
  out.loops.resize(charts);
  std::map<std::pair<int, int>, int> chain_of;  // edge, by its lower and higher point
  std::vector<std::array<char, 3>> seen(m.triangles.size(), {0, 0, 0});
  std::vector<std::vector<HalfEdge>> starts(charts);
  for (std::size_t t = 0; t < m.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      if (walk.is_border({static_cast<int>(t), k})) starts[chart[t]].push_back({static_cast<int>(t), k});
  for (int c = 0; c < charts; ++c)
    for (const HalfEdge& start : starts[c]) {
      if (seen[start.triangle][start.edge]) continue;
      std::vector<HalfEdge> loop;
      for (HalfEdge h = start; !seen[h.triangle][h.edge]; h = walk.next(h))
        seen[h.triangle][h.edge] = 1, loop.push_back(h);
      const std::size_t n = loop.size();
      std::size_t first = 0;
      while (first < n && !walk.breaks(loop[(first + n - 1) % n], loop[first])) ++first;
      const bool closed = first == n;
      std::rotate(loop.begin(), loop.begin() + static_cast<std::ptrdiff_t>(first % n), loop.end());
      auto& uses = out.loops[c].emplace_back();
      for (std::size_t k = 0; k < n;) {
        std::size_t end = k + 1;
        while (end < n && !walk.breaks(loop[end - 1], loop[end])) ++end;
        const int other = walk.other(loop[k]);
        if (other >= 0 && other < c) {
          uses.push_back({chain_of.at(std::minmax(walk.from(loop[k]), walk.to(loop[k]))), true});
        } else {
          BorderChain chain{{walk.from(loop[k])}, c, other, closed, walk.is_crease(loop[k]), 0.0};
          for (std::size_t i = k; i < end; ++i) {
            chain.points.push_back(walk.to(loop[i]));
            chain.length += (m.points[walk.to(loop[i])] - m.points[walk.from(loop[i])]).norm();
            chain_of[std::minmax(walk.from(loop[i]), walk.to(loop[i]))] = static_cast<int>(out.chains.size());
          }
          uses.push_back({static_cast<int>(out.chains.size()), false});
          out.chains.push_back(std::move(chain));
        }
        k = end;
      }
    }
  return out;
}

PlaneCurve curve_through(std::vector<Vec2> points, bool closed, std::vector<double> at) {
  struct Table {
    std::vector<Vec2> p, slope;  // slope by `at`
    std::vector<double> at;      // from 0
  };
  auto table = std::make_shared<Table>();
  table->p = std::move(points);
  const std::vector<Vec2>& p = table->p;
  const std::size_t n = p.size() - 1;
  const double length = polyline_length(p);
  if (at.empty()) {
    at.assign(1, 0.0);
    for (std::size_t k = 1; k <= n; ++k) at.push_back(at.back() + (p[k] - p[k - 1]).norm());
  }
  table->at = std::move(at);
  const auto step = [&](std::size_t k) { return Vec2(p[k + 1] - p[k]); };
  const auto long_of = [&](std::size_t k) { return std::max(1e-300, table->at[k + 1] - table->at[k]); };
  // Slope of the parabola through three points, at the middle one.
  const auto between = [&](std::size_t before, std::size_t after) {
    const double a = long_of(before), b = long_of(after);
    return Vec2((b / a * step(before) + a / b * step(after)) / (a + b));
  };
  for (std::size_t k = 0; k <= n; ++k) {
    if (k > 0 && k < n)
      table->slope.push_back(between(k - 1, k));
    else if (closed)
      table->slope.push_back(between(n - 1, 0));
    else if (n == 1)
      table->slope.push_back(step(0) / long_of(0));
    else if (k == 0)
      table->slope.push_back(2.0 * step(0) / long_of(0) - between(0, 1));
    else
      table->slope.push_back(2.0 * step(n - 1) / long_of(n - 1) - between(n - 2, n - 1));
  }
  PlaneCurve out;
  out.length = 1.02 * length, out.closed = closed;
  out.at = [table, n](double t) {
    if (t <= 0.0) return table->p.front();
    if (t >= 1.0) return table->p.back();
    const double at = t * table->at.back();
    const std::size_t k = std::min<std::size_t>(
        n - 1,
        std::max<std::ptrdiff_t>(1, std::upper_bound(table->at.begin(), table->at.end(), at) - table->at.begin()) - 1);
    const double length = table->at[k + 1] - table->at[k];
    if (length <= 0.0) return table->p[k];
    const double s = (at - table->at[k]) / length, r = 1.0 - s;
    return Vec2(r * r * (1.0 + 2.0 * s) * table->p[k] + s * s * (3.0 - 2.0 * s) * table->p[k + 1] +
                length * s * r * (r * table->slope[k] - s * table->slope[k + 1]));
  };
  return out;
}

PlaneCurve reversed(const PlaneCurve& curve) {
  return {[at = curve.at](double t) { return at(1.0 - t); }, curve.length, curve.closed};
}

ChainCurves curves_of(const TriangleMesh& m, const BorderChain& c, const std::vector<ChartPatch>& patches,
                      double element) {
  ChainCurves out;
  const auto places = [&](int chart) {
    std::vector<Vec2> p;
    for (const int i : c.points) p.push_back(patches[chart].at[i]);
    return p;
  };
  const auto gap_at = [&](const Vec2& a, const Vec2& b) {
    out.gap = std::max(out.gap, (patches[c.left].patch.evaluate(a).x - patches[c.right].patch.evaluate(b).x).norm());
  };
  if (!c.crease) {
    const std::vector<Vec2> from = places(c.left), to = places(c.right);
    const double length = polyline_length(from), edge = c.length / static_cast<double>(c.points.size() - 1);
    const int count = std::max(kFewestPlaces, static_cast<int>(std::ceil(length / (kPlacesApart * element))));
    const double step = length / count, over = std::max(kSmoothedOver * element, kSmoothedEdges * edge);
    std::vector<Vec2> left = resampled(from, count), right;
    smooth(left, c.closed, std::min(kMostSmoothing, static_cast<int>(std::ceil(2.0 * over * over / (step * step)))));
    const std::vector<Vec2> guess = resampled(to, count);
    for (int k = 0; k <= count; ++k) {
      const bool end = k == 0 || k == count;
      if (end && !c.closed)
        right.push_back(to[k == 0 ? 0 : to.size() - 1]);
      else if (end && k == count)
        right.push_back(right.front());
      else
        right.push_back(nearest_place(patches[c.right].patch, patches[c.left].patch.evaluate(left[k]).x,
                                      k == 0 ? guess[0] : Vec2(right.back() + guess[k] - guess[k - 1])));
      gap_at(left[k], right[k]);
    }
    std::vector<double> at{0.0};
    for (int k = 1; k <= count; ++k) at.push_back(at.back() + (left[k] - left[k - 1]).norm());
    out.left.push_back(curve_through(std::move(left), c.closed, at));
    out.right.push_back(curve_through(std::move(right), c.closed, at));
    return out;
  }
  const std::vector<std::size_t> corners = corners_of(m, c);
  const std::size_t n = c.points.size() - 1;
  // Points between corners, the nearest of which are left out.
  std::vector<std::vector<std::size_t>> stretches;
  if (corners.empty()) stretches.push_back({}), stretches.back().push_back(0);
  for (std::size_t k = 0; k + 1 < corners.size(); ++k) stretches.push_back({corners[k]});
  if (c.closed && !corners.empty()) stretches.push_back({corners.back()});
  for (std::size_t s = 0; s < stretches.size(); ++s) {
    std::vector<std::size_t>& own = stretches[s];
    const std::size_t begin = own[0], end = corners.empty()          ? n
                                            : s + 1 < corners.size() ? corners[s + 1]
                                                                     : corners[0] + n;
    double since = 0.0;
    for (std::size_t k = begin + 1; k < end; ++k) {
      since += (m.points[c.points[k % n]] - m.points[c.points[(k + n - 1) % n]]).norm();
      if (since >= kPlacesApart * element) own.push_back(k % n), since = 0.0;
    }
    if (since > 0.0 && since < 0.5 * kPlacesApart * element && own.size() > 2) own.pop_back();
    own.push_back(end <= n ? end : end % n);
  }
  const bool round = c.closed && corners.empty();
  for (const int chart : {c.left, c.right}) {
    if (chart < 0) continue;
    const std::vector<Vec2> p = places(chart);
    Vec3 x = Vec3::Zero();
    for (const std::vector<std::size_t>& own : stretches) {
      std::vector<Vec2> through;
      std::vector<double> at;
      for (const std::size_t k : own) {
        const double step = at.empty() ? 0.0 : (m.points[c.points[k]] - x).norm();
        at.push_back(at.empty() ? 0.0 : at.back() + step);
        x = m.points[c.points[k]], through.push_back(p[k]);
      }
      (chart == c.left ? out.left : out.right).push_back(curve_through(std::move(through), round, std::move(at)));
    }
  }
  if (c.right >= 0)
    for (const int i : c.points) gap_at(patches[c.left].at[i], patches[c.right].at[i]);
  return out;
}

}  // namespace sunder::shell
