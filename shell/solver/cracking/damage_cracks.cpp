#include "shell/solver/cracking/damage_cracks.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "shell/mechanics/principal.h"
#include "shell/solver/cracking/damage_lattice.h"
#include "shell/solver/cracking/insertion.h"

namespace sunder::shell {
namespace {

constexpr double kWatched = 0.8;   // of the strength: a layer may bear more than the mean surface stress says
constexpr double kStep = 0.75;     // spacings of an edge
constexpr double kSpent = 1.25;    // spacings beside a crack whose damage is that crack's
constexpr double kMet = 0.01;      // spacings: an end so little past a crack that its edge has met is a joint
constexpr double kShortest = 1.5;  // spacings: a shorter line waits until it has grown
constexpr double kSpur = 1.5;      // spacings: a shorter side line is noise of the boundary
constexpr double kUnhealed = 0.5;  // of a line's points: where less is still damaged, waves have passed
// Middle lines of lattice cells run through control points, where lines that meet head on differ in which side
// such a point belongs to; spacings off it none does.
constexpr double kOffLattice = 0.013;
constexpr double kJoin = 1.5, kDamagedJoin = 5.0;  // spacings an end reaches, on sound and on damaged ground
constexpr double kBeside = 0.25;  // spacings: a way that passes an open end so close runs along its crack
constexpr double kThrough = 0.8;  // of a way's cells that make it damaged ground
constexpr double kBroad = 0.7;    // of the cells around, fully damaged: no middle line tells where the crack goes
constexpr double kView = 2.0;     // spacings ahead of an end over which its stress is averaged
constexpr double kTurn = 20.0 * std::numbers::pi / 180.0;  // most per edge
constexpr double kTorn = 16.0;  // times the stress at which damage is complete: what is stretched so far is rubble

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

struct End {
  int vertex, crack, edge;
  Vec2 p, ahead;
};

// An end that has joined another crack stands just past it, on a vertex of its own.
bool joined(const ShellModel& m, const CrackGraph& g, int edge, const Vec2& end) {
  const CrackEdge& own = g.edges()[edge];
  bool met = false;
  g.near(end, end, kMet * m.spacing, [&](int e) {
    const CrackEdge& c = g.edges()[e];
    if (c.from == own.from || c.from == own.to || c.to == own.from || c.to == own.to) return true;
    Vec2 foot;
    met = g.distance(end, e, foot) < kMet * m.spacing && segments_meet(own.a, own.b, c.long_a, c.long_b);
    return !met;
  });
  return met;
}

std::vector<End> open_ends(const ShellModel& m, const CrackGraph& g) {
  std::vector<int> degree(g.vertices().size(), 0);
  for (const CrackEdge& e : g.edges()) ++degree[e.from], ++degree[e.to];
  std::vector<End> ends;
  for (std::size_t i = 0; i < g.edges().size(); ++i) {
    const CrackEdge& e = g.edges()[i];
    const int edge = static_cast<int>(i);
    const Vec2 d = (e.b - e.a).normalized();
    const auto open = [&](int vertex, const Vec2& p) {
      return degree[vertex] == 1 && m.patch.contains(p) && !joined(m, g, edge, p);
    };
    if (open(e.to, e.b)) ends.push_back({e.to, e.crack, edge, e.b, d});
    if (open(e.from, e.a)) ends.push_back({e.from, e.crack, edge, e.a, -d});
  }
  return ends;
}

// Inserts the straight way from `from` to the vertex `to` in edges of at most a spacing.
int insert_way(const ShellModel& m, ShellState& s, const End& from, int to, double time) {
  const Vec2 b = s.cracks.graph.vertices()[to];
  const int pieces = std::max(1, static_cast<int>(std::lround((b - from.p).norm() / (kStep * m.spacing))));
  int inserted = 0, last = from.vertex;
  for (int k = 1; k <= pieces; ++k) {
    const int next =
        k == pieces ? to : s.cracks.graph.add_vertex(from.p + (b - from.p) * (static_cast<double>(k) / pieces));
    inserted += insert_edge(m, s, last, next, from.crack, time, 0, false) >= 0;
    last = next;
  }
  return inserted;
}

// An end goes on to the nearest of border, open end and crack that it sees ahead: a little way on any ground,
// further where all between was fully damaged. Returns edges inserted.
int join(const ShellModel& m, ShellState& s, const DamageLattice& grid, const End& end, const std::vector<End>& ends,
         double time) {
  const double l = m.spacing;
  double nearest = kDamagedJoin * l;
  Vec2 target;
  int vertex = -1;
  bool found = false;
  const auto offer = [&](const Vec2& p, int v, int skip) {
    const Vec2 way = p - end.p;
    const double distance = way.norm();
    if (distance >= nearest || distance < 1e-6 * l || way.dot(end.ahead) < 0.3 * distance) return;
    if (!s.cracks.graph.visible(end.p, p - 1e-3 * l * way / distance, end.edge, skip)) return;
    if (distance > kJoin * l && grid.damaged_share(end.p, p) < kThrough) return;
    for (const End& other : ends) {
      const Vec2 off = other.p - end.p;
      const double along = off.dot(way) / distance;
      if (other.vertex != end.vertex && other.vertex != v && along > 0.0 && along < distance - kBeside * l &&
          (off - along * way / distance).norm() < kBeside * l)
        return;
    }
    nearest = distance, target = p, vertex = v, found = true;
  };
  for (const End& other : ends)
    if (other.vertex != end.vertex && other.edge != end.edge) offer(other.p, other.vertex, other.edge);
  s.cracks.graph.near(end.p, end.p, kDamagedJoin * l, [&](int e) {
    const CrackEdge& c = s.cracks.graph.edges()[e];
    Vec2 foot;
    if (e == end.edge || c.from == end.vertex || c.to == end.vertex) return true;
    s.cracks.graph.distance(end.p, e, foot);
    const double before = nearest;
    offer(foot, -1, e);
    if (nearest < before) target += 2e-3 * l * (foot - end.p).normalized();  // no gap at the stem
    return true;
  });
  for (int k = 1; k <= static_cast<int>(4.0 * kDamagedJoin); ++k) {
    const Vec2 p = end.p + 0.25 * k * l * end.ahead;
    if (m.patch.contains(p)) continue;
    const double before = nearest;
    offer(p, -1, -1);
    if (nearest < before) target += 0.1 * l * end.ahead;
    break;
  }
  if (!found) return 0;
  return insert_way(m, s, end, vertex >= 0 ? vertex : s.cracks.graph.add_vertex(target), time);
}

// Direction in which the undamaged stress around `p` opens a crack, of what is seen from there and lies ahead.
bool opening_direction(const ShellModel& m, const ShellState& s, const Vec2& p, const Vec2& ahead, int skip,
                       Vec2& out) {
  const RowTables& t = m.tables;
  const double radius = kView * m.spacing;
  double sum = 0.0;
  std::array<double, 6> six{};
  for (const GatheredPoint& g : s.cracked.gathered) {
    if (g.kind == PointKind::kDead) continue;
    const Vec2 q = gauss_point(m.patch, t, g.block, g.lane).parameter, d = q - p;
    if (d.squaredNorm() > radius * radius || d.dot(ahead) < 0.0 || !s.cracks.graph.visible(p + 0.01 * d, q, skip))
      continue;
    const std::array<double, 6> own = undamaged_stress(t, g, s.motion.x);
    const double w = std::exp(-2.0 * d.squaredNorm() / (radius * radius));
    sum += w;
    for (int k = 0; k < 6; ++k) six[k] += w * own[k];
  }
  if (sum <= 0.0) return false;
  const Principal low = principal(six[0], six[1], six[2]), high = principal(six[3], six[4], six[5]);
  out = high.high > low.high ? high.crack : low.crack;
  if (out.dot(ahead) < 0.0) out = -out;
  return true;
}

// In broad damage an end runs on an edge along the plane of largest principal stress.
int run_on(const ShellModel& m, ShellState& s, const DamageLattice& grid, const End& end, double time) {
  const double l = m.spacing;
  Vec2 along;
  if (grid.breadth(end.p + l * end.ahead) < kBroad || !opening_direction(m, s, end.p, end.ahead, end.edge, along))
    return 0;
  const double turn = std::atan2(end.ahead.x() * along.y() - end.ahead.y() * along.x(), end.ahead.dot(along));
  const Vec2 p = end.p + kStep * l * turned(end.ahead, std::clamp(turn, -kTurn, kTurn));
  if (!m.patch.contains(p) || !s.cracks.graph.visible(end.p, p, end.edge)) return 0;  // join runs it out, or ends it
  return insert_edge(m, s, end.vertex, s.cracks.graph.add_vertex(p), end.crack, time, 0, false) >= 0;
}

// The middle lines of what is damaged and no crack's yet.
int insert_lines(const ShellModel& m, ShellState& s, const DamageLattice& grid, double time) {
  const MedialAxis axis = medial_axis(grid.boundary(), [&](const Vec2& p) { return grid.damaged(p); });
  std::vector<int> number(axis.vertices.size(), -1);
  int inserted = 0;
  for (const auto& line : polylines(axis, kSpur * m.spacing)) {
    std::vector<Vec2> fine;
    double length = 0.0;
    int unhealed = 0, i, j;
    for (const int v : line) {
      if (!fine.empty()) length += (axis.vertices[v] - fine.back()).norm();
      fine.push_back(axis.vertices[v]);
      const int c = grid.cell_of(fine.back(), i, j);
      unhealed += c >= 0 && grid.now[c];
    }
    if (length < kShortest * m.spacing || unhealed < kUnhealed * static_cast<double>(line.size())) continue;
    std::vector<Vec2> points = resampled(std::move(fine), kStep * m.spacing);
    for (Vec2& p : points) p += kOffLattice * m.spacing * Vec2(1.0, 1.3);
    const int crack = s.cracks.graph.new_crack();
    const auto end = [&](int v, const Vec2& p) {
      if (number[v] < 0) number[v] = s.cracks.graph.add_vertex(p);
      return number[v];
    };
    int last = end(line.front(), points.front());
    for (std::size_t k = 1; k < points.size(); ++k) {
      const int next = k + 1 == points.size() ? end(line.back(), points.back()) : s.cracks.graph.add_vertex(points[k]);
      if (next != last) inserted += insert_edge(m, s, last, next, crack, time, 0, false) >= 0;
      last = next;
    }
  }
  return inserted;
}

// Broad damage that no crack has reached starts one at its most critical point.
int start_broad(const ShellModel& m, ShellState& s, const DamageLattice& grid, double time) {
  double most = 0.0;
  Vec2 p, crack;
  for (const GatheredPoint& g : s.cracked.gathered) {
    if (g.kind == PointKind::kDead) continue;
    const Vec2 q = gauss_point(m.patch, m.tables, g.block, g.lane).parameter;
    if (!grid.damaged(q) || grid.breadth(q) < kBroad) continue;
    const std::array<double, 6> six = undamaged_stress(m.tables, g, s.motion.x);
    for (int face = 0; face < 2; ++face) {
      const Principal stress = principal(six[3 * face], six[3 * face + 1], six[3 * face + 2]);
      const double ratio = stress.high / s.cracked.damage[&g - s.cracked.gathered.data()].strength;
      if (ratio > most) most = ratio, p = q, crack = stress.crack;
    }
  }
  if (most <= 0.0) return 0;
  const int a = s.cracks.graph.add_vertex(p - 0.5 * kStep * m.spacing * crack);
  const int b = s.cracks.graph.add_vertex(p + 0.5 * kStep * m.spacing * crack);
  return insert_edge(m, s, a, b, s.cracks.graph.new_crack(), time, 0, false) >= 0;
}

// What is stretched far beyond complete damage and was not cut bears no tension any more; it would only grow
// into a distorted ligament. Its material goes on with the control points around.
void tear(const ShellModel& m, ShellState& s) {
  for (std::size_t i = 0; i < s.cracked.gathered.size(); ++i) {
    GatheredPoint& g = s.cracked.gathered[i];
    PointDamage& d = s.cracked.damage[i];
    if (g.kind == PointKind::kDead || d.damage() < 1.0f) continue;
    const std::array<double, 6> six = undamaged_stress(m.tables, g, s.motion.x);
    const double limit = kTorn * d.strength * (1.0 + s.layers.brittleness) / s.layers.brittleness;
    if (std::min(principal(six[0], six[1], six[2]).high, principal(six[3], six[4], six[5]).high) < limit) continue;
    s.book.fracture += point_energy(m.tables, g, s.motion.x, &d, s.layers.brittleness, s.layers.heals);
    gather_point(m, s, g.block, g.lane);
    g.kind = PointKind::kDead, g.functions.clear();
    s.cracked.note_kind(g);
  }
}

}  // namespace

void watch_stress(const ShellModel& m, ShellState& s) {
  const RowTables& t = m.tables;
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e) {
      const std::size_t g = static_cast<std::size_t>(q) * t.lanes + e;
      const int point = s.cracked.point_of[g];
      if (point >= 0) {
        s.layers.c[g] = s.cracked.damage[point].damage(), s.layers.c_his[g] = s.cracked.damage[point].worst();
        continue;
      }
      const double* f = &s.layers.surface_stress[t.at(q, 6, 0, e)];
      double high = 0.0;
      for (int face = 0; face < 2; ++face, f += 3 * t.lanes) {
        const double half = 0.5 * (f[0] - f[t.lanes]);
        high = std::max(high, 0.5 * (f[0] + f[t.lanes]) + std::hypot(half, f[2 * t.lanes]));
      }
      // stress at rest is not in the resultants: its tension in the middle adds
      high += 0.5 * m.material.surface_compression;
      if (high > kWatched * s.layers.strength[g]) watch_point(m, s, q, e);
    }
}

int extract_cracks(const ShellModel& m, ShellState& s, double time) {
  if (s.cracked.gathered.empty()) return 0;
  tear(m, s);
  const DamageLattice grid(m, s, kSpent * m.spacing);
  int inserted = insert_lines(m, s, grid, time);
  for (const End& end : open_ends(m, s.cracks.graph)) {
    // an earlier end may have joined this one
    const std::vector<End> ends = open_ends(m, s.cracks.graph);
    if (std::none_of(ends.begin(), ends.end(), [&](const End& e) { return e.vertex == end.vertex; })) continue;
    const int joined = join(m, s, grid, end, ends, time);
    inserted += joined > 0 ? joined : run_on(m, s, grid, end, time);
  }
  return inserted > 0 ? inserted : start_broad(m, s, grid, time);
}

}  // namespace sunder::shell
