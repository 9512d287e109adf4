#include "shell/solver/cracking/tips.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "shell/mechanics/principal.h"
#include "shell/solver/cracking/abreast.h"
#include "shell/solver/cracking/clamp.h"
#include "shell/solver/cracking/crack_cost.h"
#include "shell/solver/cracking/energy_release.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/nucleation.h"
#include "shell/solver/cracking/tip_drive.h"
#include "shell/solver/cracking/tip_speed.h"

namespace sunder::shell {
namespace {

constexpr std::size_t kFewTips = 8;  // for which one thread is faster than several

// A crack that opens one face crosses a crack that opened the other and still bears: that one is closed where this one
// opens. The radial cracks of a struck pane cross its rings so.
bool crosses(const ShellState& s, int edge, const Tip& tip, const Vec2& d) {
  const CrackEdge& e = s.cracks.graph.edges()[edge];
  const int lock = s.cracks.interlock_of[edge];
  return lock >= 0 && s.cracks.interlocks[lock].holds && e.face * tip.face < 0 &&
         std::abs((e.b - e.a).normalized().dot(d)) < kCrossingCosine;
}

struct Way {
  Vec2 to;
  bool ends;                  // it ends on another crack or past the border
  std::optional<Vec2> along;  // direction of a clamped border that it follows
};

// The next edge of a tip along `wanted`, `length` long; it ends on a crack or the border within reach.
Way way_ahead(const ShellModel& m, const ShellState& s, const CrackRules& r, const Tip& tip, const Vec2& wanted,
              double length) {
  const Vec2 a = tip.p;
  Vec2 d = wanted, b = a + length * d;
  const std::optional<ClampedBorder> clamp = clamped_border(m, a, d, kOntoClamp * length);
  if (clamp) {
    const double across = (a - clamp->foot).norm();
    b = clamp->foot + std::sqrt(length * length - across * across) * clamp->along;
    d = (b - a).normalized();
  }
  bool ends = false;
  const double reach = length + r.join;
  double nearest = 2.0;
  int hit = -1;
  const Vec2 far = reach * d;
  s.cracks.graph.near(a, a + far, 0.0, [&](int e) {  // a crack straight ahead ends it
    const CrackEdge& c = s.cracks.graph.edges()[e];
    if (e == tip.edge || c.from == tip.vertex || c.to == tip.vertex) return true;
    const Vec2 q = c.long_b - c.long_a, o = c.long_a - a;
    const double det = q.x() * far.y() - far.x() * q.y();
    if (std::abs(det) < 1e-12 * q.norm() * reach) {  // on one line, as tips that meet head on along a border
      if (std::abs(o.x() * d.y() - o.y() * d.x()) > 1e-9 * m.spacing) return true;
      const double end = std::min((c.a - a).dot(d), (c.b - a).dot(d)) / reach;
      if (end > 1e-6 && end <= 1.0 && end < nearest) nearest = end, hit = e;
      return true;
    }
    const double along = (q.x() * o.y() - o.x() * q.y()) / det, across = (far.x() * o.y() - o.x() * far.y()) / det;
    // onto a tied border it runs by edges as elsewhere: it has not arrived there
    const bool far_off = c.crack == CrackEdge::kTiedTrim && along * reach > std::max(length, kFirstEdge * m.spacing);
    if (along > 1e-6 && along <= 1.0 && across >= 0.0 && across <= 1.0 && along < nearest && !far_off)
      nearest = along, hit = e;
    return true;
  });
  const double past = kJoinPast * m.spacing;  // joins go past the crack, so that nothing sees between
  if (nearest <= 1.0) {
    b = a + nearest * far + past * d;
    ends = !crosses(s, hit, tip, d);
  } else {
    double snap = kSnapShare * r.join;
    Vec2 foot, best = b;
    s.cracks.graph.near(b, b, snap, [&](int e) {
      const CrackEdge& c = s.cracks.graph.edges()[e];
      if (e == tip.edge || c.from == tip.vertex || c.to == tip.vertex) return true;
      if (c.crack == CrackEdge::kTiedTrim) return true;  // it runs beside a tied border as within a shell
      const bool own = c.crack == tip.crack || (c.crack == tip.sibling && tip.since_branch < kOwnEdges * m.spacing);
      if (own && ((c.a - a).norm() < kOwnEdges * m.spacing || (c.b - a).norm() < kOwnEdges * m.spacing)) return true;
      const double distance = s.cracks.graph.distance(b, e, foot);
      if (clamp && std::abs((foot - b).dot(Vec2(clamp->along.y(), clamp->along.x()))) > kTipsMet * m.spacing)
        return true;
      if (distance < snap && (foot - b).dot(d) > -kSnapBehind * m.spacing) snap = distance, best = foot, ends = true;
      return true;
    });
    if (ends) b = best + past * (best - a).normalized();
  }
  // a tip that comes onto the border runs along it before it may leave at a corner
  const bool lands = clamp && std::abs(clamp->along.dot(d)) < 1.0 - 1e-9;
  const Vec2 beyond = lands ? b : clamp ? Vec2(b + r.join * clamp->along) : Vec2(a + reach * d);
  if (!ends && hit < 0 && !m.patch.contains(beyond)) b = a + (reach + kRunOut * m.spacing) * d, ends = true;
  return {b, ends, clamp ? std::optional(clamp->along) : std::nullopt};
}

// The energy release of a tip along its course and across it [J/m^2], and the distance of its faces along their normals
// [m]; that is 0 unless moments ahead twist the sheet.
struct TipRelease {
  Vec2 energy;
  double apart;
};

// Replaces the drive by that of the energy release, averaged in time with `share`. A tip turns towards its energy
// release where the sheet is torn out of its plane: moments ahead twist it, and behind the tip its faces have passed
// each other.
void follow_release(Drive& drive, const TipRelease& release, const ShellModel& m, const Tip& tip, double share,
                    double most_turn) {
  const double along = release.energy.x(), across = release.energy.y();
  drive.release = tip.release < 0.0 ? along : tip.release + share * (along - tip.release);
  const bool torn = release.apart > m.thickness_at(tip.p);
  if (torn) drive.turn = along > 0.0 ? std::clamp(std::atan2(across, along), -most_turn, most_turn) : 0.0;
  if (!torn && !(drive.ratio > 0.0)) return;  // nothing opens the crack
  const double kink = torn ? 1.0 : kink_factor(drive.turn);
  drive.ratio = std::sqrt(std::max(0.0, drive.release) * kink / fracture_energy_at(m, tip.p));
}

// Settles what the edges of the tips, from `first` on, have released [J] against what they cost. An edge is inserted
// before its faces have moved, so it releases what the elements around it store, more or less than its cost. A tip that
// released less owes the rest to its next edges. What is over is energy of the motion that opens the crack, which
// the next kick gives back (apply_force_discontinuity). The first edge of a new crack keeps it: that is dust.
void settle(const ShellModel& m, ShellState& s, const std::vector<std::pair<Tip*, Vec2>>& tips, int first,
            double released) {
  double over = released;
  for (std::size_t k = 0; k < tips.size(); ++k)
    over -= edge_cost(m, s.cracks.graph.edges()[first + k]) + std::exchange(tips[k].first->owed, 0.0);
  for (const auto& [tip, direction] : tips) tip->owed = std::max(0.0, -over) / static_cast<double>(tips.size());
  const Tip& tip = *tips.front().first;
  if (tip.grown > 0.0 || tip.flaw == 0.0) s.cracks.surplus += std::max(0.0, over);
}

// Each tip runs one edge along its direction, all of them or none. `resistance`: what their area takes, over the
// fracture energy. Returns the number of edges inserted.
int advance(const ShellModel& m, ShellState& s, const CrackRules& r, const std::vector<std::pair<Tip*, Vec2>>& tips,
            double resistance, double time) {
  std::vector<Way> ways;
  int first = -1;
  double length = r.advance;
  const double taken = s.cracks.taken;
  // a tip that was refused tries longer edges now and then: little has changed since the last look
  const bool all = tips.front().first->refused % kLongerTried == 0;
  for (const double longer : kEdgesTried) {
    if (longer > kEdgesTried[0] && !all) break;
    length = longer * r.advance;
    ways.clear();
    std::vector<NewEdge> edges;
    for (const auto& [tip, d] : tips) {
      ways.push_back(way_ahead(m, s, r, *tip, d, length));
      edges.push_back({tip->vertex, ways.back().to, tip->crack, tip->face, resistance});
    }
    first = extend_cracks(m, s, edges, time, r.interlock, r.threads);
    if (first >= 0) break;
  }
  if (first < 0) return 0;
  settle(m, s, tips, first, s.cracks.taken - taken);
  for (std::size_t k = 0; k < tips.size(); ++k) {
    Tip& tip = *tips[k].first;
    const Vec2 b = ways[k].to, step = b - tip.p;
    tip.since_branch += step.norm(), tip.grown += step.norm();
    tip.edge = first + static_cast<int>(k), tip.vertex = s.cracks.graph.edges()[tip.edge].to;
    tip.direction = ways[k].along.value_or(step.normalized()), tip.p = b;
    tip.weight = tip.turn = tip.ratio = 0.0;
    tip.refused = 0;
    tip.pending -= length - r.advance;
    if (!ways[k].ends) continue;
    tip.alive = false;
    for (Tip& other : s.cracks.tips)  // tips that meet head on
      if (other.alive && (other.p - b).norm() < kTipsMet * m.spacing) other.alive = false;
  }
  return static_cast<int>(tips.size());
}

bool room_to_branch(const ShellState& s, const CrackRules& r, const Tip& tip, double spacing) {
  for (const Tip& other : s.cracks.tips)
    if (&other != &tip && other.alive && (other.p - tip.p).norm() < r.branch_clearance) return false;
  bool room = true;
  const Vec2 look = tip.p + kBranchLook * spacing * tip.direction;
  s.cracks.graph.near(look, look, kBranchRoom * spacing, [&](int e) {
    Vec2 foot;
    const CrackEdge& c = s.cracks.graph.edges()[e];
    if (c.crack == tip.crack && (c.b - tip.p).norm() < kBranchOwn * spacing) return true;
    room = s.cracks.graph.distance(look, e, foot) >= kBranchRoom * spacing;
    return room;
  });
  return room;
}

int grow_tips(const ShellModel& m, ShellState& s, const CrackRules& r, double time, double dt) {
  int inserted = 0;
  const std::size_t count = s.cracks.tips.size();
  s.caches.surroundings.of_tip.resize(count), s.caches.surroundings.ring_of_tip.resize(count);
  const auto start_of = [&](const Tip& tip) {
    Start start;
    start.p = tip.p, start.direction = tip.direction, start.edge = tip.edge, start.face = tip.face;
    start.most_turn = tip.grown > 0.0 ? r.turn : std::max(r.turn, tip.first_turn);
    start.strength = tip.strength;
    start.grown = tip.flaw > 0.0 ? std::min(1.0, (tip.grown + kCreditedLength * m.spacing) / tip.flaw) : 1.0;
    return start;
  };
  // all tips at once, which holds until one of them runs nearby
  const int known = static_cast<int>(s.cracks.graph.edges().size());
  const auto as_before = [&](const Vec2& p) {
    // an edge changes the points that a tip sees, and the stress of points that see across the edge
    const Vec2 pad = Vec2::Constant(std::max(r.tip_radius, kReleaseOuter * m.spacing)) +
                     kLargestSupport * Vec2(m.spacing_u, m.spacing_v);
    bool same = true;
    if (static_cast<int>(s.cracks.graph.edges().size()) == known) return same;
    s.cracks.graph.near_since(p - pad, p + pad, known, [&](int) { same = false; });
    return same;
  };
  const double share = std::min(1.0, dt / m.response_time());
  const auto drive_of = [&](std::size_t i, const Tip& tip) {
    const Start start = start_of(tip);
    Drive drive = drive_at(m, s, r, start, s.caches.surroundings.of_tip[i]);
    ReleaseRing& ring = s.caches.surroundings.ring_of_tip[i];
    if (const auto energy = tip_release(m, s, tip, ring))
      follow_release(drive, {*energy, drive.twisted ? faces_apart(s, ring) : 0.0}, m, tip, share, start.most_turn);
    return drive;
  };
  std::vector<Drive> drives(count);
  std::vector<std::size_t> alive;
  for (std::size_t i = 0; i < count; ++i)
    if (s.cracks.tips[i].alive) alive.push_back(i);
#pragma omp parallel for schedule(dynamic, 4) num_threads(r.threads) if (r.threads > 1 && alive.size() > kFewTips)
  for (const std::size_t i : alive) drives[i] = drive_of(i, s.cracks.tips[i]);
  const std::vector<double> shares = shares_abreast(m, s, r, drives);
  for (std::size_t i = 0; i < count; ++i) {
    Tip tip = s.cracks.tips[i];  // a copy: branching appends to the vector
    if (!tip.alive) {
      s.caches.surroundings.of_tip[i] = {}, s.caches.surroundings.ring_of_tip[i] = {};
      continue;
    }
    Drive now = as_before(tip.p) ? drives[i] : drive_of(i, tip);
    if (now.release < 0.0) now.ratio *= std::sqrt(shares[i]);
    s.cracks.tips[i].release = tip.release = now.release;
    if (now.ratio <= 1.0) continue;
    tip.face = now.face;
    const double speed = r.rayleigh * tip_speed(m.material, now.ratio * now.ratio);
    tip.pending += speed * dt;
    tip.weight += speed, tip.turn += speed * now.turn, tip.ratio += speed * now.ratio;
    if (tip.pending >= r.advance) {
      tip.pending -= r.advance;
      const Vec2 d = turned(tip.direction, tip.turn / tip.weight);
      const double drive = tip.ratio / tip.weight;
      const auto resistance = [&](double g) { return toughened(m.material, tip_speed(m.material, g)); };
      int edges = 0;
      if (drive > r.branch_ratio && tip.grown >= kWholeCrack * tip.flaw &&
          !clamped_border(m, tip.p, d, kOntoClamp * r.advance) && room_to_branch(s, r, s.cracks.tips[i], m.spacing)) {
        Tip one = tip, twin = tip;
        twin.crack = s.cracks.graph.next_crack(), twin.sibling = one.crack, one.sibling = twin.crack;
        one.since_branch = twin.since_branch = twin.owed = 0.0;
        edges = advance(m, s, r, {{&one, turned(d, r.branch_angle)}, {&twin, turned(d, -r.branch_angle)}},
                        resistance(0.5 * drive * drive), time);  // each arm has half
        if (edges > 0) s.cracks.graph.new_crack(), tip = one, s.cracks.tips.push_back(twin);
      }
      if (edges == 0) edges = advance(m, s, r, {{&tip, d}}, resistance(drive * drive), time);
      if (edges == 0) tip.pending = kRefusedPending * r.advance, ++tip.refused;
      inserted += edges;
    }
    s.cracks.tips[i] = tip;
  }
  return inserted;
}

}  // namespace

void start_at_ends(const ShellModel& m, ShellState& s, int first, int last) {
  const CrackGraph& g = s.cracks.graph;
  while (first < last && g.edges()[last - 1].is_trim()) --last;  // it has run out over a loop there
  if (first >= last) return;
  for (const bool back : {true, false}) {
    const int edge = back ? first : last - 1;
    const CrackEdge& e = g.edges()[edge];
    const Vec2 p = back ? e.a : e.b;
    bool open = m.patch.contains(p) && (m.trim.empty() || m.trim.loops.contains(p));
    g.near(p, p, kEndTaken * m.spacing, [&](int other) {
      Vec2 foot;
      const bool next = other >= first && other < last && std::abs(other - edge) <= 1;  // of the same cut
      if (!next && g.distance(p, other, foot) < kEndTaken * m.spacing) open = false;
      return open;
    });
    if (!open) continue;
    Tip tip;
    tip.p = p, tip.direction = ((back ? e.a : e.b) - (back ? e.b : e.a)).normalized();
    tip.vertex = back ? e.from : e.to, tip.edge = edge, tip.crack = e.crack, tip.first_turn = kFirstTurn;
    s.cracks.tips.push_back(tip);
  }
}

Criterion tips_by_energy() {
  return {"tips_by_energy", CrackMoment::kLook, [](const FractureRules& r) { return r.tips_run(); },
          [](const CrackLook& k) { return grow_tips(k.model, k.state, k.rules.tips, k.time, k.span); },
          [](const ShellModel& m, double dt) { return std::min(1.0, dt / m.response_time()); }};
}

}  // namespace sunder::shell
