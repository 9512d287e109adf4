#include "shell/solver/cracking/nucleation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "shell/mechanics/principal.h"
#include "shell/solver/cracking/clamp.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/tip_drive.h"

namespace sunder::shell {
namespace {

constexpr double kRoundOff = 1e-9;  // of a spacing, or of a step along a line

struct Overstressed {
  double ratio;
  int block, lane;
};

std::vector<Overstressed> overstressed_points(const ShellModel& m, ShellState& s) {
  const RowTables& t = m.tables;
  if (s.caches.marked.empty()) s.caches.marked.assign(t.blocks(), 1);
  std::vector<Overstressed> over;
  for (int q = 0; q < t.blocks(); ++q) {
    if (s.caches.marked[q]) std::fill_n(s.layers.c.begin() + static_cast<std::ptrdiff_t>(q) * t.lanes, t.spans_u, 0.0f);
    s.caches.marked[q] = 0;
    if (!s.caches.over.empty() && !s.caches.over[q]) continue;
    const double *stress = &s.layers.face_stress[t.at(q, 6, 0, 0)], *strength = &s.layers.strength[t.at(q, 1, 0, 0)];
    for (int first = 0; first < t.spans_u; first += kLanes) {
      const auto field = [&](int k) { return load<Pack>(stress + k * t.lanes + first); };
      const Pack resists = load<Pack>(strength + first), uncertain = kSurelyBelow * resists;
      if (!any((most_tension(field(0), field(1), field(2)) > uncertain) |
               (most_tension(field(3), field(4), field(5)) > uncertain)))
        continue;
      const auto largest = [&](int face) {
        const Pack s11 = field(3 * face), s22 = field(3 * face + 1), s12 = field(3 * face + 2);
        const Pack half = 0.5 * (s11 - s22);
        return 0.5 * (s11 + s22) + square_root(half * half + s12 * s12);
      };
      const Pack low = largest(0), high = largest(1), most = select(low > high, low, high);
      const IntPack above = most > resists;
      for (int lane = first; lane < std::min(t.spans_u, first + kLanes); ++lane) {
        if (!above[lane - first]) continue;
        const std::size_t g = static_cast<std::size_t>(q) * t.lanes + lane;
        s.layers.c[g] = 1.0f, s.caches.marked[q] = 1;
        if (s.layers.c_his[g] < 1.0f) s.layers.c_his[g] = 1.0f;
        if (s.cracked.kind(g) != PointKind::kQuadratic) continue;
        over.push_back({most[lane - first] / resists[lane - first], q, lane});
      }
    }
  }
  std::sort(over.begin(), over.end(), [](const Overstressed& a, const Overstressed& b) {
    return a.ratio != b.ratio ? a.ratio > b.ratio : a.block != b.block ? a.block < b.block : a.lane < b.lane;
  });
  return over;
}

// Whether p belongs to a tip that runs: all of its process zone does, and further out what lies ahead of it or beside
// it. `running`: tips that are alive.
bool near_a_tip(const ShellModel& m, const ShellState& s, const CrackRules& r, const std::vector<int>& running,
                const Vec2& p) {
  for (const int i : running) {
    const Tip& tip = s.cracks.tips[i];
    if ((tip.p - p).norm() < r.tip_clearance &&
        ((tip.p - p).norm() < r.process_length || (p - tip.p).dot(tip.direction) > -kBesideTip * m.spacing) &&
        s.cracks.graph.visible(p, tip.p + kEyeAhead * m.spacing * tip.direction, tip.edge))
      return true;
  }
  return false;
}

// The Gauss point nearest to q in the element of q.
std::pair<int, int> point_at(const ShellModel& m, const Vec2& q) {
  const GaussRule& rule = gauss_rule(m.tables.gauss);
  const auto nearest = [&](const KnotVector& knots, int span, double at) {
    int best = 0;
    double least = 1e300;
    for (int k = 0; k < m.tables.gauss; ++k) {
      const double away = std::abs(gauss_parameter(knots, rule, span, k) - at);
      if (away < least) least = away, best = k;
    }
    return best;
  };
  const int lane = m.patch.knots_u.span_of(q.x()), row = m.patch.knots_v.span_of(q.y());
  const int a = nearest(m.patch.knots_u, lane, q.x()), b = nearest(m.patch.knots_v, row, q.y());
  int block = (row * m.tables.gauss + b) * m.tables.gauss + a;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < m.tables.gauss * m.tables.gauss && !m.tables.trimmed.empty(); ++k) {
    const int other = row * m.tables.gauss * m.tables.gauss + k;
    const GaussPoint g = gauss_point(m.patch, m.tables, other, lane);
    const double away = (g.parameter - q).squaredNorm();
    if (g.weight > 0.0 && away < least) least = away, block = other;
  }
  return {block, lane};
}

// Mean stress around a Gauss point, as `mean_stress`. The direction of the stress at one point would be that of the
// lattice.
bool stress_around(const ShellModel& m, ShellState& s, const CrackRules& r, int block, int lane, double time,
                   double* face_stress) {
  const std::size_t gauss = m.tables.at(block, 1, 0, lane);
  KnownMean& mean = s.caches.surroundings.mean_of_point.at(s.cracked.point_of.size(), gauss,
                                                           sizeof(KnownMean) + most_bytes_seen(m, r.tip_radius));
  if (mean.time != time || mean.edges != s.cracks.graph.edges().size()) {  // many lines use the same points
    mean.found = mean_stress(m, s, gauss_point(m.patch, m.tables, block, lane).parameter, r.tip_radius, mean.around,
                             mean.face_stress);
    mean.time = time, mean.edges = s.cracks.graph.edges().size();
  }
  std::copy_n(mean.face_stress, 6, face_stress);
  return mean.found;
}

// Mean along a line of the local fracture energy over that of the material: the square of the strength factor.
double mean_resistance(const ShellModel& m, const FlawLine& line) {
  const int steps = static_cast<int>(std::ceil(std::min(line.length() / m.spacing, kFarthest))) + 1;
  double sum = 0.0;
  for (int k = 0; k < steps; ++k) {
    const double at = (k + 0.5) / steps * line.length() - line.behind;
    const auto [block, lane] = point_at(m, line.p + at * line.along);
    const double factor = m.strength_factor_at(block, lane);
    sum += factor * factor;
  }
  return sum / steps;
}

// The end of a crack that starts at p towards `to`: there, or on a border before it at which ties hold another shell.
struct FirstEnd {
  Vec2 at;
  bool on_tie = false;
};

FirstEnd end_towards(const ShellModel& m, const CrackGraph& cracks, const Vec2& p, const Vec2& to) {
  const Vec2 way = to - p;
  double nearest = 2.0;
  cracks.near(p, to, 0.0, [&](int e) {
    const CrackEdge& c = cracks.edges()[e];
    if (c.crack != CrackEdge::kTiedTrim || !segments_meet(p, to, c.long_a, c.long_b)) return true;
    const Vec2 edge = c.long_b - c.long_a, from = c.long_a - p;
    const double across = way.x() * edge.y() - way.y() * edge.x();
    if (across != 0.0) nearest = std::min(nearest, (from.x() * edge.y() - from.y() * edge.x()) / across);
    return true;
  });
  if (nearest > 1.0) return {to};
  return {p + nearest * way + kJoinPast * m.spacing * way.normalized(), true};
}

// Starts a crack from vertex `from` to the point `to`; its open end lives on, but on a tie, where the next shell may
// continue it.
int start_crack(const ShellModel& m, ShellState& s, const CrackRules& r, int from, const FirstEnd& end, const Tip& kind,
                double time) {
  const Vec2& to = end.at;
  Tip tip = kind;
  tip.alive = !end.on_tie;
  tip.edge = extend_cracks(m, s, {{from, to, tip.crack, tip.face}}, time, r.interlock, r.threads);
  if (tip.edge < 0) {
    s.cracks.graph.undo_vertex();  // the other end is new as well
    return 0;
  }
  tip.vertex = s.cracks.graph.edges()[tip.edge].to;
  tip.p = to, tip.direction = (to - s.cracks.graph.vertices()[from]).normalized();
  s.cracks.tips.push_back(tip);
  return 1;
}

// The crack along a direction that a field of this shape would open at the strength.
struct Critical {
  double half_length;  // [m]; infinite: none
  double zone;         // radius of its energy-release zone [m]
  double stored;       // stored_by of that field at the strength [Pa^2]
};

Critical critical_across(const ShellModel& m, double strength, const double* face_stress, const Vec2& along) {
  const double low = across(face_stress, along), high = across(face_stress + 3, along);
  const double stretching = 0.5 * (low + high), bending = 0.5 * std::abs(high - low);
  const double half_length = critical_length(m.material, strength, stretching, bending);
  const double sum = std::max(0.0, stretching) + bending;
  return {half_length, std::min(zone_radius(m.material, half_length, stretching, bending), kFarthest * m.spacing),
          sum > 0.0 ? strength * strength * stored_by(stretching / sum, bending / sum) : 0.0};
}

EnergyReleaseZone& zone_of(ShellState& s, std::size_t gauss) {
  return s.caches.surroundings.zone_of_point.at(s.cracked.point_of.size(), gauss, sizeof(EnergyReleaseZone));
}

// Whether so little of the energy-release zone is left that the point needs no closer look, which takes much longer. A
// rule of its own, not a bound of `opens_along`: it uses the stress at the point, not its mean on a line.
bool lacks_zone(const ShellModel& m, ShellState& s, const Overstressed& o, const Vec2& p, std::size_t gauss) {
  double here[6];
  if (!face_stress_at(m, s, o.block, o.lane, here)) return true;
  const Principal low = principal(here[0], here[1], here[2]), high = principal(here[3], here[4], here[5]);
  const Vec2& along = high.high > low.high ? high.crack : low.crack;
  const double strength = s.layers.strength[gauss] / m.strength_factor_at(o.block, o.lane);
  const Critical crack = critical_across(m, strength, here, along);
  if (!(crack.half_length > m.spacing) || !std::isfinite(crack.half_length)) return false;
  // with this stress as the mean on a line: half the line is the shortest that opens, and needs 1 / energy
  const double energy = o.ratio * o.ratio, zone = zone_of(s, gauss).share(m, s.cracks.graph, p, crack.zone);
  return energy * energy * zone * kShortestOpens < 1.0;
}

// `refused` becomes true where a flaw longer than a spacing has no energy-release zone of its own.
int nucleate_at(const ShellModel& m, ShellState& s, const CrackRules& r, const std::vector<int>& running,
                const Overstressed& o, double time, std::uint64_t& random, bool& refused) {
  const Vec2 flaw = gauss_point(m.patch, m.tables, o.block, o.lane).parameter;
  Vec2 p = flaw;  // start of the crack
  const std::size_t gauss = m.tables.at(o.block, 1, 0, o.lane), points = s.cracked.point_of.size();
  NearCracks& beside = s.caches.surroundings.cracks_of_point.at(points, gauss, kBytesOfCracks);
  const double reach = std::max(kStartsOnCrack * m.spacing, r.parallel_clearance);
  const std::vector<SeenEdge>& cracks = beside.seen(s.cracks.graph, p, reach, r.parallel_clearance, kParallelCosine);
  if (beside.shield_all() || near_a_tip(m, s, r, running, p)) return 0;
  if (lacks_zone(m, s, o, p, gauss)) return refused = true, 0;
  double face_stress[6];
  if (!stress_around(m, s, r, o.block, o.lane, time, face_stress)) return 0;
  const Principal low = principal(face_stress[0], face_stress[1], face_stress[2]),
                  high = principal(face_stress[3], face_stress[4], face_stress[5]);
  const int face = high.high > low.high ? 1 : -1;
  const Principal& stress = face > 0 ? high : low;
  const bool alike = stress.low > r.alike * stress.high;  // then any direction is as good: chance decides
  Vec2 join_foot, join_way;
  double join = kStartsOnCrack * m.spacing;
  bool joins = false;
  Vec2 along = stress.crack;
  for (const SeenEdge& c : cracks) {
    if (c.distance < r.parallel_clearance && std::abs(c.along.dot(stress.crack)) > kParallelCosine) return 0;
    if (c.distance < join) join = c.distance, join_foot = c.foot, join_way = c.along, joins = true;
  }
  if (alike && !joins) along = turned(Vec2(1, 0), std::numbers::pi * uniform(random));
  if (const auto clamp = clamped_start(m, s.cracks.graph, flaw, along)) {
    const auto met = joins ? met_at(*clamp, join_foot, join_way, kStartsOnCrack * m.spacing) : std::nullopt;
    if (!joins || (met && m.patch.contains(*met))) p = clamp->foot, along = clamp->along;
    if (met && p != flaw) join_foot = *met;
  }
  // A flaw becomes a crack through the thickness only where the crack would run on. Strength alone, at a point that a
  // wave passes, would fill the sheet with cracks one edge long.
  Tip kind;
  // the drive is taken against the resistance of the material
  kind.strength = s.layers.strength[gauss] / m.strength_factor_at(o.block, o.lane);
  kind.face = face;
  const Critical crack = critical_across(m, kind.strength, face_stress, along);
  if (!std::isfinite(crack.half_length)) return 0;  // the field does not open it
  kind.flaw = crack.half_length;
  if (crack.half_length > m.spacing) {  // the grid resolves the length that a crack needs to run by its energy
    EnergyReleaseZone& own = zone_of(s, gauss);
    const double share = own.share(m, s.cracks.graph, flaw, crack.zone);
    const FlawLine line = line_through(m, s.cracks.graph, p, along, crack.half_length);
    if (!opens_along(m, s, r, line, face, {crack.half_length, kind.strength, share}, time)) return 0;
    const double even = crack.stored * mean_resistance(m, line);
    const double stored = stored_in_zone(m, s, own, crack.zone, flaw, along, face, even);
    if (!(2.0 * crack.half_length * stored >= line.length())) return 0;
  }
  double strongest = 0.0;
  for (const double sign : {-1.0, 1.0}) {
    Start start;
    start.p = p, start.direction = sign * along, start.strength = kind.strength, start.grown = 0.0;
    strongest = std::max(strongest, drive_at(m, s, r, start).ratio);
  }
  if (strongest <= 1.0) return 0;
  kind.crack = s.cracks.graph.new_crack();
  if (joins) {
    const Vec2 d = (p - join_foot).dot(along) > 0.0 ? along : Vec2(-along);
    const FirstEnd end = end_towards(m, s.cracks.graph, join_foot, join_foot + kFirstEdge * m.spacing * d);
    return start_crack(m, s, r, s.cracks.graph.add_vertex(join_foot - kJoinPast * m.spacing * d), end, kind, time);
  }
  const FirstEnd first = end_towards(m, s.cracks.graph, p, p - 0.5 * kFirstEdge * m.spacing * along),
                 last = end_towards(m, s.cracks.graph, p, p + 0.5 * kFirstEdge * m.spacing * along);
  const int a = s.cracks.graph.add_vertex(first.at);
  const int inserted = start_crack(m, s, r, a, last, kind, time);
  if (inserted > 0) {
    Tip back = s.cracks.tips.back();
    back.vertex = a, back.p = s.cracks.graph.vertices()[a], back.direction = -along;
    back.alive = !first.on_tie;
    s.cracks.tips.push_back(back);
  }
  return inserted;
}

}  // namespace

FlawLine line_through(const ShellModel& m, const CrackGraph& cracks, const Vec2& p, const Vec2& along,
                      double half_length) {
  const Vec2 low(m.patch.knots_u.begin(), m.patch.knots_v.begin()), high(m.patch.knots_u.end(), m.patch.knots_v.end());
  const auto free = [&](const Vec2& way) {
    double most = std::min(half_length, kFarthest * m.spacing);
    for (int k = 0; k < 2; ++k)
      if (way[k] != 0.0) most = std::min(most, std::max(0.0, ((way[k] > 0.0 ? high : low)[k] - p[k]) / way[k]));
    const Vec2 to = p + most * way;
    double before = most;
    cracks.near(p, to, 0.0, [&](int e) {
      const CrackEdge& c = cracks.edges()[e];
      const Vec2 edge = c.long_b - c.long_a, from = c.long_a - p;
      const double across = way.x() * edge.y() - way.y() * edge.x(), off = way.x() * from.y() - way.y() * from.x();
      if (std::max(std::abs(across), std::abs(off)) <
          kRoundOff * m.spacing) {  // on one line, for example along a clamp
        const double first = std::min(from.dot(way), (c.long_b - p).dot(way));
        if (std::max(from.dot(way), (c.long_b - p).dot(way)) > 0.0) before = std::min(before, std::max(0.0, first));
        return true;
      }
      if (!segments_meet(p, to, c.long_a, c.long_b)) return true;
      if (across != 0.0) before = std::min(before, std::max(0.0, (from.x() * edge.y() - from.y() * edge.x()) / across));
      return true;
    });
    return before;
  };
  return {p, along, free(along), free(-along)};
}

bool opens_along(const ShellModel& m, ShellState& s, const CrackRules& r, const FlawLine& line, int face,
                 const Flaw& flaw, double time) {
  const double step = flaw.half_length / std::ceil(std::min(flaw.half_length / m.spacing, kFarthest));
  double sum = 0.0;
  int samples = 0;
  for (int k = -static_cast<int>(line.behind / step + kRoundOff); k * step <= line.ahead + kRoundOff * step; ++k) {
    const auto [block, lane] = point_at(m, line.p + k * step * line.along);
    double face_stress[6];
    if (stress_around(m, s, r, block, lane, time, face_stress))  // else the place bears nothing
      sum += across(face_stress + (face > 0 ? 3 : 0), line.along) / m.strength_factor_at(block, lane);
    ++samples;
  }
  const double over = sum / (samples * flaw.strength);  // energy grows with the square
  return over >= 1.0 && over * over * line.length() >= flaw.half_length &&
         over * over * flaw.zone * 2.0 * flaw.half_length >= line.length();
}

double stored_in_zone(const ShellModel& m, const ShellState& s, EnergyReleaseZone& own, double radius, const Vec2& p,
                      const Vec2& along, int face, double even) {
  const double share = own.share(m, s.cracks.graph, p, radius), reach = std::min(radius, own.reach());
  const auto every = [&](const KnotVector& k, double at) {
    return std::max(1, (k.span_of(at + reach) - k.span_of(at - reach)) / kZoneSamples);
  };
  double sum = 0.0, all = 0.0;
  points_within(m, p, reach, every(m.patch.knots_u, p.x()), every(m.patch.knots_v, p.y()),
                [&](int block, int lane, const Vec2& offset, double area) {
                  if (!own.holds(offset)) return;
                  all += area;
                  double face_stress[6];
                  if (!face_stress_at(m, s, block, lane, face_stress)) return;
                  const double low = across(face_stress, along), high = across(face_stress + 3, along);
                  const double opens = face > 0 ? high : low, stretching = 0.5 * (low + high);
                  if (opens > 0.0) sum += area * stored_by(stretching, stretching > 0.0 ? 0.5 * (high - low) : opens);
                });
  return all > 0.0 ? share * sum / (all * even) : 0.0;
}

int nucleate(const ShellModel& m, ShellState& s, const CrackRules& r, double time, std::uint64_t& random) {
  int inserted = 0, known = 0;
  std::vector<int> running;
  const int each = m.tables.gauss * m.tables.gauss;
  thread_local std::vector<char>
      refused;  // [v][u] elements that lack their zone; the most overstressed flaw is asked first
  refused.assign(static_cast<std::size_t>(m.tables.blocks() / each) * m.tables.spans_u, 0);
  for (const Overstressed& o : overstressed_points(m, s)) {
    // one that lacks its zone answers for the others of the element
    char& spoken = refused[static_cast<std::size_t>(o.block / each) * m.tables.spans_u + o.lane];
    if (spoken != 0) continue;
    for (; known < static_cast<int>(s.cracks.tips.size()); ++known)
      if (s.cracks.tips[known].alive) running.push_back(known);
    bool now = false;
    const int edges = nucleate_at(m, s, r, running, o, time, random, now);
    spoken = now ? 1 : 0;
    inserted += edges;
  }
  return inserted;
}

Criterion nucleation_by_strength() {
  return {"nucleation_by_strength", CrackMoment::kLook, [](const FractureRules& r) { return r.tips_run(); },
          [](const CrackLook& k) { return nucleate(k.model, k.state, k.rules.tips, k.time, k.random); },
          [](const ShellModel& m, double dt) { return std::min(1.0, dt / m.response_time()); }};
}

}  // namespace sunder::shell
