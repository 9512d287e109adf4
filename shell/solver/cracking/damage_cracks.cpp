#include "shell/solver/cracking/damage_cracks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "shell/mechanics/principal.h"
#include "shell/mechanics/row_force.h"
#include "shell/solver/cracking/damage_lattice.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/forces.h"

namespace sunder::shell {
namespace {

// Smooths the steps of the cells out of a line, whose ends stay, and cuts it into edges of about `step` [m].
std::vector<Vec2> resampled(std::vector<Vec2> line, double step) {
  for (int pass = 0; pass < kSmoothings; ++pass) {
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

// Whether an end has joined another crack: it then stands just past it, on a vertex of its own.
bool joined(const ShellModel& m, const CrackGraph& g, int edge, const Vec2& end) {
  const CrackEdge& own = g.edges()[edge];
  bool met = false;
  g.near(end, end, kEndJoined * m.spacing, [&](int e) {
    const CrackEdge& c = g.edges()[e];
    if (c.from == own.from || c.from == own.to || c.to == own.from || c.to == own.to) return true;
    Vec2 foot;
    met = g.distance(end, e, foot) < kEndJoined * m.spacing && segments_meet(own.a, own.b, c.long_a, c.long_b);
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

// Inserts the straight way from `from` to the vertex `to`, in edges of about kEdgeLength.
int insert_way(const ShellModel& m, ShellState& s, const End& from, int to, double time, bool faces) {
  const Vec2 b = s.cracks.graph.vertices()[to];
  const int pieces = std::max(1, static_cast<int>(std::lround((b - from.p).norm() / (kEdgeLength * m.spacing))));
  int inserted = 0, last = from.vertex;
  for (int k = 1; k <= pieces; ++k) {
    const int next =
        k == pieces ? to : s.cracks.graph.add_vertex(from.p + (b - from.p) * (static_cast<double>(k) / pieces));
    inserted += insert_edge(m, s, last, next, from.crack, time, 0, faces) >= 0;
    last = next;
  }
  return inserted;
}

// An end runs to the nearest of border, open end and crack that it sees ahead: a short way over sound material, further
// where all between was fully damaged. Returns the number of edges inserted.
int join(const ShellModel& m, ShellState& s, const DamageRules& r, const DamageLattice& grid, const End& end,
         const std::vector<End>& ends, double time) {
  const double l = m.spacing;
  double nearest = r.damaged_reach * l;
  Vec2 target;
  int vertex = -1;
  bool found = false;
  const auto offer = [&](const Vec2& p, int v, int skip) {
    const Vec2 way = p - end.p;
    const double distance = way.norm();
    if (distance >= nearest || distance < 1e-6 * l || way.dot(end.ahead) < kAheadCosine * distance) return;
    if (!s.cracks.graph.visible(end.p, p - kShortOfWay * l * way / distance, end.edge, skip)) return;
    if (distance > kSoundReach * l && grid.damaged_share(end.p, p) < r.through_damage) return;
    for (const End& other : ends) {
      const Vec2 off = other.p - end.p;
      const double along = off.dot(way) / distance;
      if (other.vertex != end.vertex && other.vertex != v && along > 0.0 && along < distance - kPassesEnd * l &&
          (off - along * way / distance).norm() < kPassesEnd * l)
        return;
    }
    nearest = distance, target = p, vertex = v, found = true;
  };
  for (const End& other : ends)
    if (other.vertex != end.vertex && other.edge != end.edge) offer(other.p, other.vertex, other.edge);
  s.cracks.graph.near(end.p, end.p, r.damaged_reach * l, [&](int e) {
    const CrackEdge& c = s.cracks.graph.edges()[e];
    Vec2 foot;
    if (e == end.edge || c.from == end.vertex || c.to == end.vertex) return true;
    s.cracks.graph.distance(end.p, e, foot);
    const double before = nearest;
    offer(foot, -1, e);
    if (nearest < before) target += kJoinPast * l * (foot - end.p).normalized();  // no gap at the stem
    return true;
  });
  for (int k = 1; k <= static_cast<int>(r.damaged_reach / kBorderSteps); ++k) {
    const Vec2 p = end.p + kBorderSteps * k * l * end.ahead;
    if (m.patch.contains(p)) continue;
    const double before = nearest;
    offer(p, -1, -1);
    if (nearest < before) target += kRunOut * l * end.ahead;
    break;
  }
  if (!found) return 0;
  return insert_way(m, s, end, vertex >= 0 ? vertex : s.cracks.graph.add_vertex(target), time, r.faces);
}

const std::vector<double>* plastic_states(const ShellState& s) {
  return s.layers.plastic.empty() ? nullptr : &s.layers.plastic;
}

// Direction in which the undamaged stress opens a crack, on the mean over visible points ahead of `p`. False where none
// bears.
bool opening_direction(const ShellModel& m, const ShellState& s, const Vec2& p, const Vec2& ahead, int skip,
                       Vec2& out) {
  const RowTables& t = m.tables;
  const double radius = kTipRadius * m.spacing;
  double sum = 0.0;
  std::array<double, 6> face_stress{};
  for (const GatheredPoint& g : s.cracked.gathered) {
    if (g.kind == PointKind::kDead) continue;
    const Vec2 q = gauss_point(m.patch, t, g.block, g.lane).parameter, d = q - p;
    if (d.squaredNorm() > radius * radius || d.dot(ahead) < 0.0 || !s.cracks.graph.visible(p + kEyeShare * d, q, skip))
      continue;
    const std::array<double, 6> own = undamaged_stress(t, g, s.motion.x, plastic_states(s));
    const double w = std::exp(-kRadialFall * d.squaredNorm() / (radius * radius));
    sum += w;
    for (int k = 0; k < 6; ++k) face_stress[k] += w * own[k];
  }
  if (sum <= 0.0) return false;
  const Principal low = principal(face_stress[0], face_stress[1], face_stress[2]),
                  high = principal(face_stress[3], face_stress[4], face_stress[5]);
  out = high.high > low.high ? high.crack : low.crack;
  if (out.dot(ahead) < 0.0) out = -out;
  return true;
}

// In broad damage an end runs by one edge along the plane of the largest principal stress.
int run_on(const ShellModel& m, ShellState& s, const DamageRules& r, const DamageLattice& grid, const End& end,
           double time) {
  const double l = m.spacing;
  Vec2 along;
  if (grid.breadth(end.p + l * end.ahead) < r.broad_damage ||
      !opening_direction(m, s, end.p, end.ahead, end.edge, along))
    return 0;
  const double turn = std::atan2(end.ahead.x() * along.y() - end.ahead.y() * along.x(), end.ahead.dot(along));
  const Vec2 p = end.p + kEdgeLength * l * turned(end.ahead, std::clamp(turn, -r.turn, r.turn));
  if (!m.patch.contains(p) || !s.cracks.graph.visible(end.p, p, end.edge))
    return 0;  // join() lets it run out, or ends it
  return insert_edge(m, s, end.vertex, s.cracks.graph.add_vertex(p), end.crack, time, 0, r.faces) >= 0;
}

// Inserts the middle lines of damaged regions that belong to no crack yet.
int insert_lines(const ShellModel& m, ShellState& s, const DamageRules& r, const DamageLattice& grid, double time) {
  const MedialAxis axis = medial_axis(grid.boundary(), [&](const Vec2& p) { return grid.damaged(p); });
  std::vector<int> number(axis.vertices.size(), -1);
  int inserted = 0;
  for (const auto& line : polylines(axis, r.spur * m.spacing)) {
    std::vector<Vec2> fine;
    double length = 0.0;
    int unhealed = 0, i, j;
    for (const int v : line) {
      if (!fine.empty()) length += (axis.vertices[v] - fine.back()).norm();
      fine.push_back(axis.vertices[v]);
      const int c = grid.cell_of(fine.back(), i, j);
      unhealed += c >= 0 && grid.now[c];
    }
    if (length < r.shortest_line * m.spacing || unhealed < r.unhealed * static_cast<double>(line.size())) continue;
    std::vector<Vec2> points = resampled(std::move(fine), kEdgeLength * m.spacing);
    for (Vec2& p : points) p += kOffLattice * m.spacing * Vec2(kNudgeU, kNudgeV);
    const int crack = s.cracks.graph.new_crack();
    const auto end = [&](int v, const Vec2& p) {
      if (number[v] < 0) number[v] = s.cracks.graph.add_vertex(p);
      return number[v];
    };
    int last = end(line.front(), points.front());
    for (std::size_t k = 1; k < points.size(); ++k) {
      const int next = k + 1 == points.size() ? end(line.back(), points.back()) : s.cracks.graph.add_vertex(points[k]);
      if (next != last) inserted += insert_edge(m, s, last, next, crack, time, 0, r.faces) >= 0;
      last = next;
    }
  }
  return inserted;
}

// Broad damage that no crack has reached starts a crack at its most critical point: of equal ones, at the first.
int start_broad(const ShellModel& m, ShellState& s, const DamageRules& r, const DamageLattice& grid, double time) {
  constexpr double kRoundOff = 1e-9;  // of the ratio
  double most = 0.0;
  Vec2 p, crack;
  for (const GatheredPoint& g : s.cracked.gathered) {
    if (g.kind == PointKind::kDead) continue;
    const Vec2 q = gauss_point(m.patch, m.tables, g.block, g.lane).parameter;
    if (!grid.damaged(q) || grid.breadth(q) < r.broad_damage) continue;
    const std::array<double, 6> face_stress = undamaged_stress(m.tables, g, s.motion.x, plastic_states(s));
    for (int face = 0; face < 2; ++face) {
      const Principal stress = principal(face_stress[3 * face], face_stress[3 * face + 1], face_stress[3 * face + 2]);
      const double ratio = stress.high / s.cracked.damage[&g - s.cracked.gathered.data()].strength;
      if (ratio > (1.0 + kRoundOff) * most) most = ratio, p = q, crack = stress.crack;
    }
  }
  if (most <= 0.0) return 0;
  const int a = s.cracks.graph.add_vertex(p - 0.5 * kEdgeLength * m.spacing * crack);
  const int b = s.cracks.graph.add_vertex(p + 0.5 * kEdgeLength * m.spacing * crack);
  return insert_edge(m, s, a, b, s.cracks.graph.new_crack(), time, 0, r.faces) >= 0;
}

// A point that is stretched far beyond complete damage and was not cut becomes rubble: it bears no tension any more,
// and would only grow into a distorted ligament. The stress of some laws grows no further however far they are
// stretched: then the stretch decides. Its limit is that of pure shear, beyond which a linear law's stress is as large.
void tear(const ShellModel& m, ShellState& s, const DamageRules& r) {
  for (std::size_t i = 0; i < s.cracked.gathered.size(); ++i) {
    GatheredPoint& g = s.cracked.gathered[i];
    PointDamage& d = s.cracked.damage[i];
    if (g.kind == PointKind::kDead || d.damage() < 1.0f) continue;
    const std::array<double, 6> face_stress = undamaged_stress(m.tables, g, s.motion.x, plastic_states(s));
    const double limit = r.torn_stress * d.strength * (1.0 + s.layers.brittleness) / s.layers.brittleness;
    const double strain = limit * (1.0 + m.material.poisson_ratio) / m.material.youngs_modulus;
    if (std::min(principal(face_stress[0], face_stress[1], face_stress[2]).high,
                 principal(face_stress[3], face_stress[4], face_stress[5]).high) < limit &&
        largest_stretch(m.tables, g, s.motion.x, plastic_states(s)) < 1.0 + strain)
      continue;
    RowPlasticity plastic;
    if (s.yields()) plastic = plasticity_of(m, s);
    s.book.fracture += point_energy(m.tables, g, s.motion.x,
                                    {&d, s.layers.brittleness, s.layers.heals, s.yields() ? &plastic : nullptr});
    gather_point(m, s, g.block, g.lane);
    g.kind = PointKind::kDead, g.functions.clear();
    s.cracked.note_kind(g);
  }
}

// Shares of its shape at rest, beyond the flow, that a point keeps: [-], 0 where it is inside out.
struct Kept {
  double middle = 0.0;  // of the area of the middle surface
  double least = 0.0;   // of area, the least of middle surface and layers, by the true curvature
  double folded = 0.0;  // of a length of the middle surface as it is, the least of layers
  bool bears = true;    // as the laws of the material see it
};

// Share of area that the metric `c` keeps of `a`. A metric that is inside out in both directions has a positive
// determinant and a negative trace.
double kept_area(const Sym2<double>& c, const Sym2<double>& a) {
  return c.c11 + c.c22 > 0.0 ? std::sqrt(std::max(0.0, determinant(c)) / determinant(a)) : 0.0;
}

// The least share of a length. A fold that is drawn lengthwise keeps its area while its layers are pressed across.
double kept_length(const Sym2<double>& c, const Sym2<double>& a) {
  if (kept_area(c, a) == 0.0) return 0.0;
  const double half = 0.5 * (c.c11 * a.c22 + c.c22 * a.c11 - 2.0 * c.c12 * a.c12) / determinant(a);
  const double product = determinant(c) / determinant(a);  // of both squares
  return std::sqrt(product / (half + std::sqrt(std::max(0.0, half * half - product))));
}

Kept kept_shape(const ShellModel& m, const ShellState& s, const GatheredPoint& g) {
  const Layers& layers = m.tables.layers;
  const int count = static_cast<int>(layers.zeta.size());
  const Forms<double> f = surface_forms(gather(m.tables, g, s.motion.x));
  const OnePlace place{m.tables, g.block, g.lane};
  Sym2<double> middle = g.metric.a;
  const double most = std::numeric_limits<double>::infinity();
  Kept out{0.0, most, most, bears(f, g.metric, layers)};
  for (int l = 0; l < count; ++l) {
    Sym2<double> a = reference_at(g.metric, layers, l), flow{};
    if (s.yields()) {
      const auto field = [&](int k) { return place.load(s.layers.plastic, 4 * count, 4 * l + k); };
      flow = {field(0), field(1), field(2)};
    }
    a = {a.c11 + flow.c11, a.c22 + flow.c22, a.c12 + flow.c12};
    const double share = layers.weight[l] / thickness_of(layers);
    middle = {middle.c11 + share * flow.c11, middle.c22 + share * flow.c22, middle.c12 + share * flow.c12};
    const Sym2<double> c = at_height(f.a, f.b, layers.zeta[l]);
    out.least = std::min(out.least, kept_area(c, a)), out.folded = std::min(out.folded, kept_length(c, f.a));
  }
  out.middle = kept_area(f.a, middle);
  out.least = std::min(out.least, out.middle);
  return out;
}

// Gives a point a weaker kind, and books the energy that it loses. It keeps the share of the full energy that its
// damage has left it.
void release_point(const ShellModel& m, ShellState& s, PointKind kind, GatheredPoint& g, PointDamage& d) {
  RowPlasticity layers;
  if (s.yields()) layers = plasticity_of(m, s);
  const RowPlasticity* plastic = s.yields() ? &layers : nullptr;
  const PointDamage old = d;
  const PointMemory memory{&old, s.layers.brittleness, s.layers.heals, plastic};
  const PointMemory of_full{plastic ? &old : nullptr, s.layers.brittleness, s.layers.heals, plastic};
  const double full = full_energy(m.tables, g, s.motion.x, of_full);
  const double held = point_energy(m.tables, g, s.motion.x, memory);
  g.kind = kind, g.stamp = fresh_stamp();
  if (kind == PointKind::kDead) g.functions.clear();
  s.cracked.note_kind(g);
  const double left = full_energy(m.tables, g, s.motion.x, of_full);
  d.fresh = true, d.retained = 0.0;
  if (s.layers.heals)
    d.retained = full > 0.0 ? left * std::clamp(1.0 - held / full, 0.0, 1.0) : 0.0;
  else
    settle_damage(m.tables, g, s.motion.x, memory, d);
  const double lost = held - (left - d.retained);
  (lost < 0.0 ? s.book.injected : s.book.fracture) += std::abs(lost);
}

// Whether the points of a pack, whose six fields are `lanes` apart, are surely below the stress from which they are
// listed: a bound says so without a root.
bool surely_calm(const double* stress, int lanes, const double* strength, double at_rest) {
  const auto field = [&](int k) { return load<Pack>(stress + k * lanes); };
  const Pack one = most_tension(field(0), field(1), field(2)), other = most_tension(field(3), field(4), field(5));
  const Pack most = select(one > other, one, other), limit = kSurelyBelow * kWatched * load<Pack>(strength);
  const Pack tension = select(most > 0.0, most, Pack{});
  return !any(tension + at_rest > limit);
}

// Whether none of the points of a pack is listed: its number is -1 then.
bool none_listed(const int* point_of) {
  int both = -1;
  for (int lane = 0; lane < kLanes; ++lane) both &= point_of[lane];
  return both < 0;
}

}  // namespace

void watch_stress(const ShellModel& m, ShellState& s) {
  const RowTables& t = m.tables;
  if (!s.layers.through.empty())
    for (int q = 0; q < t.blocks(); ++q)
      for (int e = 0; e < t.spans_u; ++e)
        if (s.layers.fibre_damage(static_cast<std::size_t>(q) * t.lanes + e) > 0.0f) watch_point(m, s, q, e);
  // stress at rest is not in the resultants: its tension in the middle is added
  const double at_rest = kTemperedMiddle * m.material.surface_compression;
  for (int q = 0; q < t.blocks(); ++q) {
    const std::size_t start = static_cast<std::size_t>(q) * t.lanes;
    const double* stress = &s.layers.face_stress[t.at(q, 6, 0, 0)];
    for (int first = 0; first < t.spans_u; first += kLanes) {
      if (surely_calm(stress + first, t.lanes, &s.layers.strength[start + first], at_rest) &&
          none_listed(&s.cracked.point_of[start + first]))
        continue;
      for (int e = first; e < std::min(t.spans_u, first + kLanes); ++e) {
        const int point = s.cracked.point_of[start + e];
        if (point >= 0) {
          s.layers.c[start + e] = s.damage(point), s.layers.c_his[start + e] = s.worst_damage(point);
          continue;
        }
        const double* f = stress + e;
        double high = 0.0;
        for (int face = 0; face < 2; ++face, f += 3 * t.lanes) {
          const double half = 0.5 * (f[0] - f[t.lanes]);
          high = std::max(high, 0.5 * (f[0] + f[t.lanes]) + std::hypot(half, f[2 * t.lanes]));
        }
        if (high + at_rest > kWatched * s.layers.strength[start + e]) watch_point(m, s, q, e);
      }
    }
  }
}

void release_folds(const ShellModel& m, ShellState& s) {
  for (std::size_t i = 0; i < s.cracked.gathered.size(); ++i) {
    GatheredPoint& g = s.cracked.gathered[i];
    PointDamage& d = s.cracked.damage[i];
    if (g.kind == PointKind::kDead || d.worst() < 1.0f) continue;
    const Kept kept = kept_shape(m, s, g);
    const bool crushed = kept.middle < kFoldedArea;
    const bool folded = std::min(kept.least, kept.folded) < kFoldedArea;
    if (!crushed && (g.kind == PointKind::kLinear || !folded)) continue;
    gather_point(m, s, g.block, g.lane);
    // a fold that bears nothing, as it is inside out, would bear again by its middle surface alone
    release_point(m, s, crushed || !kept.bears ? PointKind::kDead : PointKind::kLinear, g, d);
  }
}

int extract_cracks(const ShellModel& m, ShellState& s, double time, const DamageRules& r) {
  if (s.cracked.gathered.empty()) return 0;
  tear(m, s, r);
  release_folds(m, s);
  const DamageLattice grid(m, s, r.spent_beside * m.spacing);
  int inserted = insert_lines(m, s, r, grid, time);
  for (const End& end : open_ends(m, s.cracks.graph)) {
    // an earlier end may have joined this one
    const std::vector<End> ends = open_ends(m, s.cracks.graph);
    if (std::none_of(ends.begin(), ends.end(), [&](const End& e) { return e.vertex == end.vertex; })) continue;
    const int joined = join(m, s, r, grid, end, ends, time);
    inserted += joined > 0 ? joined : run_on(m, s, r, grid, end, time);
  }
  return inserted > 0 ? inserted : start_broad(m, s, r, grid, time);
}

Criterion cracks_from_damage() {
  return {"cracks_from_damage",
          CrackMoment::kLook,
          [](const FractureRules& r) { return r.damages(); },
          [](const CrackLook& k) {
            return k.rules.damage.extract ? extract_cracks(k.model, k.state, k.time, k.rules.damage) : 0;
          },
          [](const ShellModel&, double) { return 1.0; },
          [](const CrackLook& k) { watch_stress(k.model, k.state); }};
}

}  // namespace sunder::shell
