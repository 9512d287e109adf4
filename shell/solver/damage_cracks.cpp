#include "shell/solver/damage_cracks.h"

#include <algorithm>
#include <cmath>

#include "shell/fracture/medial_axis.h"
#include "shell/solver/insertion.h"

namespace sunder::shell {
namespace {

constexpr double kWatched = 0.8;   // of the strength: a layer may bear more than the mean surface stress says
constexpr double kSpent = 1.5;     // spacings beside a crack whose damage is that crack's
constexpr double kShortest = 1.5;  // spacings: a shorter line waits until it has grown
constexpr double kSpur = 1.5;      // spacings: a shorter side line is noise of the boundary
constexpr double kStep = 0.75;     // spacings of an edge
constexpr double kTipReach = 3.0, kStemReach = 2.0, kBorderReach = 2.0;  // spacings

// The Gauss points as cells of a lattice over the parameter domain.
struct Lattice {
  const ShellModel& m;
  int columns, rows;
  std::vector<char> damaged, spent;

  explicit Lattice(const ShellModel& model)
      : m(model), columns(model.tables.spans_u * model.tables.gauss), rows(model.tables.spans_v * model.tables.gauss) {
    damaged.assign(static_cast<std::size_t>(columns) * rows, 0);
    spent = damaged;
  }
  std::size_t at(int i, int j) const { return static_cast<std::size_t>(j) * columns + i; }
  bool holds(int i, int j) const { return i >= 0 && j >= 0 && i < columns && j < rows; }
  static double side(const KnotVector& k, int gauss, int i) {
    const int span = std::min(i / gauss, k.spans() - 1);
    return k.span_begin(span) + k.span_length(span) * (static_cast<double>(i) / gauss - span);
  }
  Vec2 corner(int i, int j) const {
    return {side(m.patch.knots_u, m.tables.gauss, i), side(m.patch.knots_v, m.tables.gauss, j)};
  }
  Vec2 centre(int i, int j) const { return 0.5 * (corner(i, j) + corner(i + 1, j + 1)); }
  bool inside(const Vec2& p) const {
    const KnotVector &u = m.patch.knots_u, &v = m.patch.knots_v;
    if (!m.patch.contains(p)) return false;
    const int su = u.span_of(p.x()), sv = v.span_of(p.y()), g = m.tables.gauss;
    const int i = su * g + std::min(g - 1, static_cast<int>(g * (p.x() - u.span_begin(su)) / u.span_length(su)));
    const int j = sv * g + std::min(g - 1, static_cast<int>(g * (p.y() - v.span_begin(sv)) / v.span_length(sv)));
    return damaged[at(i, j)];
  }
};

Lattice lattice_of(const ShellModel& m, const ShellState& s) {
  Lattice grid(m);
  const RowTables& t = m.tables;
  for (std::size_t k = 0; k < s.points.size(); ++k) {
    if (s.damage[k].worst() < 1.0f) continue;
    const int block = s.points[k].block, row = block / t.gauss;  // row = f * gauss + b
    const int i = s.points[k].lane * t.gauss + block % t.gauss;
    bool spent = false;
    const Vec2 p = grid.centre(i, row);
    s.cracks.near(p, p, kSpent * m.spacing, [&](int e) {
      Vec2 foot;
      spent = s.cracks.distance(p, e, foot) < kSpent * m.spacing;
      return !spent;
    });
    (spent ? grid.spent : grid.damaged)[grid.at(i, row)] = 1;
  }
  return grid;
}

std::vector<BoundarySample> boundary(const Lattice& grid) {
  std::vector<BoundarySample> seeds;
  constexpr int kBlur = 2;  // cells: the normal is that of the blurred region, not of its steps
  for (int j = 0; j < grid.rows; ++j)
    for (int i = 0; i < grid.columns; ++i) {
      if (!grid.damaged[grid.at(i, j)]) continue;
      for (const auto& [di, dj] : {std::pair{1, 0}, std::pair{-1, 0}, std::pair{0, 1}, std::pair{0, -1}}) {
        if (!grid.holds(i + di, j + dj) || grid.damaged[grid.at(i + di, j + dj)]) continue;
        BoundarySample seed;
        const Vec2 a = grid.corner(i + (di == 1), j + (dj == 1));
        const Vec2 b = grid.corner(i + (di != -1), j + (dj != -1));
        seed.p = 0.5 * (a + b);
        seed.historical = grid.spent[grid.at(i + di, j + dj)];
        Vec2 inward = Vec2::Zero();
        for (int q = -kBlur; q <= kBlur; ++q)
          for (int r = -kBlur; r <= kBlur; ++r)
            if (grid.holds(i + r, j + q) && grid.damaged[grid.at(i + r, j + q)])
              inward += (grid.centre(i + r, j + q) - seed.p).normalized();
        seed.outward = inward.norm() > 1e-9 ? Vec2(-inward.normalized()) : Vec2(di, dj);
        seeds.push_back(seed);
      }
    }
  return seeds;
}

// Smooths the steps of the cells out of a line, ends held, and cuts it into edges.
std::vector<Vec2> resampled(std::vector<Vec2> line, double step) {
  for (int pass = 0; pass < 4; ++pass) {
    const std::vector<Vec2> old = line;
    for (std::size_t i = 1; i + 1 < line.size(); ++i) line[i] = 0.25 * (old[i - 1] + 2.0 * old[i] + old[i + 1]);
  }
  std::vector<double> along{0.0};
  for (std::size_t i = 1; i < line.size(); ++i) along.push_back(along.back() + (line[i] - line[i - 1]).norm());
  const int pieces = std::max(1, static_cast<int>(std::lround(along.back() / step)));
  std::vector<Vec2> out{line.front()};
  std::size_t k = 1;
  for (int i = 1; i < pieces; ++i) {
    const double at = along.back() * i / pieces;
    while (k + 1 < line.size() && along[k] < at) ++k;
    const double share = (at - along[k - 1]) / std::max(along[k] - along[k - 1], 1e-300);
    out.push_back(line[k - 1] + share * (line[k] - line[k - 1]));
  }
  out.push_back(line.back());
  return out;
}

// Graph vertex that an open end of a new line goes on to, or -1; border and stems get a new one.
int bridge(const ShellModel& m, ShellState& s, const Vec2& end, const Vec2& ahead, std::size_t old_edges) {
  const double l = m.spacing;
  std::vector<int> degree(s.cracks.vertices().size(), 0);
  for (std::size_t e = 0; e < old_edges; ++e) ++degree[s.cracks.edges()[e].from], ++degree[s.cracks.edges()[e].to];
  int tip = -1;
  double nearest = kTipReach * l;
  for (std::size_t v = 0; v < degree.size(); ++v) {
    const Vec2 to = s.cracks.vertices()[v] - end;
    if (degree[v] == 1 && to.norm() < nearest && to.dot(ahead) > -0.5 * to.norm())
      nearest = to.norm(), tip = static_cast<int>(v);
  }
  if (tip >= 0) return tip;
  double reach = kStemReach * l;
  Vec2 foot, stem;
  bool joins = false;
  s.cracks.near(end, end, reach, [&](int e) {
    if (static_cast<std::size_t>(e) >= old_edges) return true;
    const double distance = s.cracks.distance(end, e, foot);
    if (distance < reach && (foot - end).dot(ahead) > -0.5 * distance) reach = distance, stem = foot, joins = true;
    return true;
  });
  if (joins) return s.cracks.add_vertex(stem + 2e-3 * l * (stem - end).normalized());
  if (!m.patch.contains(end + kBorderReach * l * ahead))
    return s.cracks.add_vertex(end + (kBorderReach + 0.1) * l * ahead);
  return -1;
}

// Earlier tips that no new line has gone on from reach out to the nearest new vertex.
int meet_tips(const ShellModel& m, ShellState& s, std::size_t old_edges, std::size_t old_vertices, double time) {
  if (s.cracks.edges().size() == old_edges) return 0;
  std::vector<int> degree(s.cracks.vertices().size(), 0), crack(s.cracks.vertices().size(), 0);
  for (const CrackEdge& e : s.cracks.edges()) {
    ++degree[e.from], ++degree[e.to];
    crack[e.from] = crack[e.to] = e.crack;
  }
  int inserted = 0;
  for (std::size_t v = 0; v < old_vertices; ++v) {
    if (degree[v] != 1 || !m.patch.contains(s.cracks.vertices()[v])) continue;
    double nearest = kTipReach * m.spacing;
    int to = -1;
    for (std::size_t w = old_vertices; w < degree.size(); ++w) {
      const double distance = (s.cracks.vertices()[w] - s.cracks.vertices()[v]).norm();
      if (degree[w] > 0 && distance < nearest) nearest = distance, to = static_cast<int>(w);
    }
    if (to >= 0) inserted += insert_edge(m, s, static_cast<int>(v), to, crack[v], time, 0, false) >= 0;
  }
  return inserted;
}

}  // namespace

void watch_stress(const ShellModel& m, ShellState& s) {
  const RowTables& t = m.tables;
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e) {
      const std::size_t g = static_cast<std::size_t>(q) * t.lanes + e;
      const int point = s.point_of[g];
      if (point >= 0) {
        s.c[g] = s.damage[point].damage(), s.c_his[g] = s.damage[point].worst();
        continue;
      }
      const double* f = &s.surface_stress[t.at(q, 6, 0, e)];
      double high = 0.0;
      for (int face = 0; face < 2; ++face, f += 3 * t.lanes) {
        const double half = 0.5 * (f[0] - f[t.lanes]);
        high = std::max(high, 0.5 * (f[0] + f[t.lanes]) + std::hypot(half, f[2 * t.lanes]));
      }
      if (high > kWatched * s.strength[g]) gather_point(m, s, q, e);
    }
}

int extract_cracks(const ShellModel& m, ShellState& s, double time) {
  std::size_t complete = 0;
  for (const PointDamage& d : s.damage) complete += d.worst() >= 1.0f;
  if (complete == s.complete_seen) return 0;
  s.complete_seen = complete;
  const Lattice grid = lattice_of(m, s);
  const MedialAxis axis = medial_axis(boundary(grid), [&](const Vec2& p) { return grid.inside(p); });
  const std::size_t old_edges = s.cracks.edges().size(), old_vertices = s.cracks.vertices().size();
  std::vector<int> number(axis.vertices.size(), -1), degree(axis.vertices.size(), 0);
  const std::vector<std::vector<int>> lines = polylines(axis, kSpur * m.spacing);
  for (const auto& line : lines) ++degree[line.front()], ++degree[line.back()];
  int inserted = 0;
  for (const auto& line : lines) {
    std::vector<Vec2> fine;
    double length = 0.0;
    for (const int v : line) {
      if (!fine.empty()) length += (axis.vertices[v] - fine.back()).norm();
      fine.push_back(axis.vertices[v]);
    }
    if (length < kShortest * m.spacing) continue;
    const std::vector<Vec2> points = resampled(std::move(fine), kStep * m.spacing);
    const int crack = s.cracks.new_crack();
    const auto edge = [&](int from, int to) {
      if (from != to) inserted += insert_edge(m, s, from, to, crack, time, 0, false) >= 0;
    };
    const auto end = [&](int v, const Vec2& p) {
      if (number[v] < 0) number[v] = s.cracks.add_vertex(p);
      return number[v];
    };
    int last = end(line.front(), points.front());
    const int first = last;
    for (std::size_t i = 1; i < points.size(); ++i) {
      const int next = i + 1 == points.size() ? end(line.back(), points.back()) : s.cracks.add_vertex(points[i]);
      edge(last, next);
      last = next;
    }
    const std::size_t n = points.size();
    if (degree[line.front()] == 1) {
      const int to = bridge(m, s, points[0], (points[0] - points[1]).normalized(), old_edges);
      if (to >= 0) edge(first, to);
    }
    if (degree[line.back()] == 1) {
      const int to = bridge(m, s, points[n - 1], (points[n - 1] - points[n - 2]).normalized(), old_edges);
      if (to >= 0) edge(last, to);
    }
  }
  return inserted + meet_tips(m, s, old_edges, old_vertices, time);
}

}  // namespace sunder::shell
