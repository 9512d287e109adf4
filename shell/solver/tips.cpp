#include "shell/solver/tips.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "shell/mechanics/principal.h"
#include "shell/solver/insertion.h"

namespace sunder::shell {
namespace {

constexpr double kCrushing = 10.0;       // compressive over tensile strength of glass and ceramics, about
constexpr double kCrossingCosine = 0.7;  // a tip that meets a crack at a flatter angle follows it

double across(const double* s, const Vec2& q) {  // normal stress on a crack along q
  return q.y() * q.y() * s[0] + q.x() * q.x() * s[1] - 2.0 * q.x() * q.y() * s[2];
}

// What drives a tip: sqrt(energy release / resistance), the face that opens it and the turn towards the
// best direction within the limit. Energy releases of stretching and of bending add; compression closes
// the face that bending opens.
struct Drive {
  double ratio = 0.0, turn = 0.0;
  int face = 0;
};
Drive drive_of(const double* six, const Vec2& d, const CrackRules& r) {
  Drive best;
  for (const int face : {-1, 1}) {
    const double* own = face < 0 ? six : six + 3;
    const double* other = face < 0 ? six + 3 : six;
    Vec2 along = principal(own[0], own[1], own[2]).crack;
    if (along.dot(d) < 0.0) along = -along;
    Drive q;
    q.face = face;
    q.turn = std::clamp(std::atan2(d.x() * along.y() - d.y() * along.x(), d.dot(along)), -r.turn, r.turn);
    const Vec2 c = turned(d, q.turn);
    const double here = across(own, c), there = across(other, c);
    const double stretch = 0.5 * (here + there), bend = 0.5 * (here - there);
    if (stretch > 0.0)
      q.ratio = std::hypot(stretch / r.tip_strength, std::max(0.0, bend) / r.tip_bending_strength);
    else
      q.ratio = std::max(0.0, here) / r.tip_bending_strength;
    if (q.ratio > best.ratio) best = q;
  }
  return best;
}

template <class F>
void gauss_points_near(const ShellModel& m, const Vec2& p, double radius, F&& f) {
  const RowTables& t = m.tables;
  const auto &ku = m.patch.knots_u, &kv = m.patch.knots_v;
  for (int j = kv.span_of(p.y() - radius); j <= kv.span_of(p.y() + radius); ++j)
    for (int i = ku.span_of(p.x() - radius); i <= ku.span_of(p.x() + radius); ++i)
      for (int sub = 0; sub < t.gauss * t.gauss; ++sub) {
        const int block = j * t.gauss * t.gauss + sub;
        const Vec2 q = gauss_point(m.patch, t, block, i).parameter;
        if ((q - p).squaredNorm() <= radius * radius) f(block, i, q);
      }
}

bool stress_at(const ShellModel& m, const ShellState& s, int block, int lane, double* six) {
  const int point = s.point_of[static_cast<std::size_t>(block) * m.tables.lanes + lane];
  if (point >= 0 && s.points[point].kind == PointKind::kDead) return false;
  for (int k = 0; k < 6; ++k) six[k] = s.surface_stress[m.tables.at(block, 6, k, lane)];
  return true;
}

// Mean stress of both faces over the half disc ahead of a tip, on its own side of cracks.
bool stress_ahead(const ShellModel& m, const ShellState& s, const CrackRules& r, const Tip& tip, double* six) {
  std::fill(six, six + 6, 0.0);
  double sum = 0.0;
  const Vec2 eye = tip.p + 0.1 * m.spacing * tip.direction;
  gauss_points_near(m, tip.p, r.tip_radius, [&](int block, int lane, const Vec2& q) {
    const Vec2 d = q - tip.p;
    double here[6];
    if (d.dot(tip.direction) <= 0.0 || !s.cracks.visible(eye, q, tip.edge) || !stress_at(m, s, block, lane, here))
      return;
    const double w = std::exp(-2.0 * d.squaredNorm() / (r.tip_radius * r.tip_radius));
    sum += w;
    for (int k = 0; k < 6; ++k) six[k] += w * here[k];
  });
  if (sum <= 0.0) return false;
  for (int k = 0; k < 6; ++k) six[k] /= sum;
  return true;
}

// A crack that opens one face runs across one that opened the other and still keys, for that one is closed
// where this one opens: the radial cracks of a struck pane cross its rings.
bool crosses(const ShellState& s, int edge, const Tip& tip, const Vec2& d) {
  const CrackEdge& e = s.cracks.edges()[edge];
  const int lock = s.interlock_of[edge];
  return lock >= 0 && s.interlocks[lock].holds && e.face * tip.face < 0 &&
         std::abs((e.b - e.a).normalized().dot(d)) < kCrossingCosine;
}

// Runs the tip one edge along d; ends on what lies within reach. Returns edges inserted.
int advance(const ShellModel& m, ShellState& s, const CrackRules& r, Tip& tip, const Vec2& d, double time) {
  const Vec2 a = tip.p;
  Vec2 b = a + r.advance * d;
  bool ends = false;
  const double reach = r.advance + r.join;
  double nearest = 2.0;
  int hit = -1;
  const Vec2 far = reach * d;
  s.cracks.near(a, a + far, 0.0, [&](int e) {  // straight ahead: end on it
    const CrackEdge& c = s.cracks.edges()[e];
    if (e == tip.edge || c.from == tip.vertex || c.to == tip.vertex) return true;
    const Vec2 q = c.long_b - c.long_a, o = c.long_a - a;
    const double det = q.x() * far.y() - far.x() * q.y();
    if (std::abs(det) < 1e-30) return true;
    const double along = (q.x() * o.y() - o.x() * q.y()) / det, across = (far.x() * o.y() - o.x() * far.y()) / det;
    if (along > 1e-6 && along <= 1.0 && across >= 0.0 && across <= 1.0 && along < nearest) nearest = along, hit = e;
    return true;
  });
  const double past = 2e-3 * m.spacing;  // joins cross what they join, so that nothing sees between
  if (nearest <= 1.0) {
    b = a + nearest * far + past * d;
    ends = !crosses(s, hit, tip, d);
  } else {
    double snap = 0.7 * r.join;
    Vec2 foot, best = b;
    s.cracks.near(b, b, snap, [&](int e) {
      const CrackEdge& c = s.cracks.edges()[e];
      if (e == tip.edge || c.from == tip.vertex || c.to == tip.vertex) return true;
      if (c.crack == tip.crack && ((c.a - a).norm() < 2.0 * m.spacing || (c.b - a).norm() < 2.0 * m.spacing))
        return true;
      const double distance = s.cracks.distance(b, e, foot);
      if (distance < snap && (foot - b).dot(d) > -0.1 * m.spacing) snap = distance, best = foot, ends = true;
      return true;
    });
    if (ends) b = best + past * (best - a).normalized();
  }
  if (!ends && hit < 0 && !m.patch.contains(a + reach * d)) b = a + (reach + 0.1 * m.spacing) * d, ends = true;
  const int vertex = s.cracks.add_vertex(b);
  const int edge = insert_edge(m, s, tip.vertex, vertex, tip.crack, time, tip.face, r.interlock);
  if (edge < 0) {
    tip.alive = false;
    return 0;
  }
  tip.since_branch += (b - a).norm();
  tip.edge = edge, tip.vertex = vertex, tip.direction = (b - a).normalized(), tip.p = b;
  std::fill(tip.mean, tip.mean + 7, 0.0);
  if (ends) tip.alive = false;
  return 1;
}

bool room_to_branch(const ShellState& s, const CrackRules& r, const Tip& tip, double spacing) {
  for (const Tip& other : s.tips)
    if (&other != &tip && other.alive && (other.p - tip.p).norm() < r.tip_clearance) return false;
  bool room = true;
  const Vec2 look = tip.p + 2.0 * spacing * tip.direction;
  s.cracks.near(look, look, 1.5 * spacing, [&](int e) {
    Vec2 foot;
    const CrackEdge& c = s.cracks.edges()[e];
    if (c.crack == tip.crack && (c.b - tip.p).norm() < 2.0 * spacing) return true;
    room = s.cracks.distance(look, e, foot) >= 1.5 * spacing;
    return room;
  });
  return room;
}

int grow_tips(const ShellModel& m, ShellState& s, const CrackRules& r, double time, double dt) {
  int inserted = 0;
  const std::size_t count = s.tips.size();
  const double rayleigh = m.rayleigh_speed();
  for (std::size_t i = 0; i < count; ++i) {
    Tip tip = s.tips[i];  // a copy: branching appends to the vector
    if (!tip.alive) continue;
    double six[6];
    if (!stress_ahead(m, s, r, tip, six)) {
      s.tips[i].alive = false;
      continue;
    }
    const Drive now = drive_of(six, tip.direction, r);
    if (now.ratio <= 1.0) continue;
    tip.face = now.face;
    // Freund: energy release falls to zero at the Rayleigh speed; it balances the resistance at this speed
    const double speed = std::min(r.speed_limit, rayleigh * (1.0 - 1.0 / (now.ratio * now.ratio)));
    tip.pending += speed * dt;
    for (int k = 0; k < 6; ++k) tip.mean[k] += speed * six[k];
    tip.mean[6] += speed;
    if (tip.pending >= r.advance) {
      tip.pending -= r.advance;
      for (int k = 0; k < 6; ++k) six[k] = tip.mean[k] / tip.mean[6];
      const Drive mean = drive_of(six, tip.direction, r);
      const Vec2 d = turned(tip.direction, mean.turn);
      if (mean.ratio > r.branch_ratio && tip.since_branch > r.branch_spacing &&
          room_to_branch(s, r, s.tips[i], m.spacing)) {
        Tip twin = tip;
        inserted += advance(m, s, r, tip, turned(d, r.branch_angle), time);
        inserted += advance(m, s, r, twin, turned(d, -r.branch_angle), time);
        tip.since_branch = twin.since_branch = 0.0;
        s.tips.push_back(twin);
      } else {
        inserted += advance(m, s, r, tip, d, time);
      }
    }
    s.tips[i] = tip;
  }
  return inserted;
}

double uniform(std::uint64_t& state) {  // splitmix64
  std::uint64_t z = (state += 0x9e3779b97f4a7c15ULL);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
}

struct Overstressed {
  double ratio;
  int block, lane;
};

int nucleate_at(const ShellModel& m, ShellState& s, const CrackRules& r, const Overstressed& o, double time,
                std::uint64_t& random) {
  const Vec2 p = gauss_point(m.patch, m.tables, o.block, o.lane).parameter;
  for (const Tip& tip : s.tips)
    if (tip.alive && (tip.p - p).norm() < r.tip_clearance &&
        s.cracks.visible(p, tip.p - 0.05 * m.spacing * tip.direction, tip.edge))
      return 0;
  double six[6];
  if (!stress_at(m, s, o.block, o.lane, six)) return 0;
  const Principal low = principal(six[0], six[1], six[2]), high = principal(six[3], six[4], six[5]);
  const int face = high.high > low.high ? 1 : -1;
  const Principal& stress = face > 0 ? high : low;
  Vec2 join_foot;
  double join = 1.5 * m.spacing;
  bool joins = false, shielded = false;
  s.cracks.near(p, p, r.parallel_clearance, [&](int e) {
    Vec2 foot;
    const double distance = s.cracks.distance(p, e, foot);
    if (distance > r.parallel_clearance || !s.cracks.visible(p, foot + 0.02 * (p - foot), e)) return true;
    const CrackEdge& c = s.cracks.edges()[e];
    if (std::abs((c.b - c.a).normalized().dot(stress.crack)) > 0.6) return !(shielded = true);
    if (distance < join) join = distance, join_foot = foot, joins = true;
    return true;
  });
  if (shielded) return 0;
  // A flaw becomes a crack through the thickness only where it would run on: strength alone, at a point that
  // a wave passes, would leave the sheet full of cracks one edge long.
  double strongest = 0.0;
  for (const double sign : {-1.0, 1.0}) {
    Tip tip;
    tip.p = p, tip.direction = sign * stress.crack;
    double ahead[6];
    if (stress_ahead(m, s, r, tip, ahead)) strongest = std::max(strongest, drive_of(ahead, tip.direction, r).ratio);
  }
  if (strongest <= 1.0) return 0;
  const int crack = s.cracks.new_crack();
  int inserted = 0;
  const auto start = [&](int from, const Vec2& to) {
    Tip tip;
    const Vec2 root = s.cracks.vertices()[from];
    tip.vertex = s.cracks.add_vertex(to);
    tip.edge = insert_edge(m, s, from, tip.vertex, crack, time, face, r.interlock);
    if (tip.edge < 0) return;
    tip.p = to, tip.direction = (to - root).normalized(), tip.crack = crack, tip.face = face;
    s.tips.push_back(tip);
    ++inserted;
  };
  if (joins) {
    const Vec2 d = (p - join_foot).dot(stress.crack) > 0.0 ? stress.crack : Vec2(-stress.crack);
    start(s.cracks.add_vertex(join_foot - 2e-3 * m.spacing * d), join_foot + m.spacing * d);
  } else if (stress.low > r.star_ratio * stress.high) {
    const double phase = 2.0 * std::numbers::pi * uniform(random);
    const int root = s.cracks.add_vertex(p);
    for (int arm = 0; arm < r.star_arms; ++arm)
      start(root, p + m.spacing * turned(Vec2(1, 0), phase + 2.0 * std::numbers::pi * arm / r.star_arms));
  } else {
    const int a = s.cracks.add_vertex(p - 0.5 * m.spacing * stress.crack),
              b = s.cracks.add_vertex(p + 0.5 * m.spacing * stress.crack);
    const int edge = insert_edge(m, s, a, b, crack, time, face, r.interlock);
    if (edge >= 0) {
      ++inserted;
      for (const int end : {b, a}) {
        Tip tip;
        tip.vertex = end, tip.edge = edge, tip.crack = crack, tip.face = face;
        tip.p = s.cracks.vertices()[end], tip.direction = end == b ? stress.crack : Vec2(-stress.crack);
        s.tips.push_back(tip);
      }
    }
  }
  return inserted;
}

int nucleate(const ShellModel& m, ShellState& s, const CrackRules& r, double time, std::uint64_t& random) {
  const RowTables& t = m.tables;
  std::vector<Overstressed> over;
  for (int q = 0; q < t.blocks(); ++q) {
    const double* stress = &s.surface_stress[t.at(q, 6, 0, 0)];
    const double* strength = &s.strength[static_cast<std::size_t>(q) * t.lanes];
    for (int e = 0; e < t.spans_u; ++e) {
      double high = 0.0;
      for (int face = 0; face < 2; ++face) {
        const double* f = stress + 3 * face * t.lanes + e;
        const double half = 0.5 * (f[0] - f[t.lanes]);
        high = std::max(high, 0.5 * (f[0] + f[t.lanes]) + std::sqrt(half * half + f[2 * t.lanes] * f[2 * t.lanes]));
      }
      const std::size_t g = static_cast<std::size_t>(q) * t.lanes + e;
      s.c[g] = high > strength[e] ? 1.0f : 0.0f;
      if (high <= strength[e]) continue;
      const int point = s.point_of[g];
      if (s.c_his[g] < 1.0f) s.c_his[g] = 1.0f;
      if (point >= 0 && s.points[point].kind != PointKind::kQuadratic) continue;
      over.push_back({high / strength[e], q, e});
    }
  }
  std::sort(over.begin(), over.end(), [](const Overstressed& a, const Overstressed& b) {
    return a.ratio != b.ratio ? a.ratio > b.ratio : a.block != b.block ? a.block < b.block : a.lane < b.lane;
  });
  int inserted = 0, nucleated = 0;
  for (const Overstressed& o : over) {
    if (nucleated >= r.nucleations_per_step) break;
    const int edges = nucleate_at(m, s, r, o, time, random);
    inserted += edges;
    nucleated += edges > 0;
  }
  return inserted;
}

// Mean opening stress over the half disc ahead of a tip, weight exp(-2 r^2/R^2), in units of
// sqrt(E G/R). kRadial is the mean of (r/R)^-1/2.
constexpr double kRadial = 1.5420;
// Stretching, K = sqrt(E G): sigma = K / sqrt(2 pi r) cos(t/2) (1 + sin(t/2) sin(3t/2)), mean of angles 1.1704
constexpr double kStretchMean = 1.1704 * kRadial * 0.39894;
// Bending of a Kirchhoff-Love plate (Williams 1961): surface stress k / sqrt(2 r) g(t) with the energy
// release k^2 pi (1 + nu) / (3 E (3 + nu)); g from w = r^3/2 (a cos 3t/2 + b cos t/2) with free faces.
double bending_mean(double nu) {
  constexpr int kAngles = 200;
  double sum = 0.0;
  for (int i = 0; i < kAngles; ++i) {
    const double t = std::numbers::pi * ((i + 0.5) / kAngles - 0.5), c1 = std::cos(0.5 * t), c3 = std::cos(1.5 * t);
    const double rr = (3.0 + 5.0 * nu) * c1 - (7.0 + nu) * c3, tt = (5.0 + 3.0 * nu) * c1 + (7.0 + nu) * c3;
    const double rt = (7.0 + nu) * std::sin(1.5 * t) - (1.0 - nu) * std::sin(0.5 * t);
    const double s = std::sin(t), c = std::cos(t);
    sum += (rr * s * s + tt * c * c + 2.0 * rt * s * c) / (4.0 * (3.0 + nu) * kAngles);
  }
  return sum * kRadial / std::numbers::sqrt2 * std::sqrt(3.0 * (3.0 + nu) / (std::numbers::pi * (1.0 + nu)));
}

}  // namespace

CrackRules make_crack_rules(const ShellModel& m, double tip_radius) {
  const double l = m.spacing;
  CrackRules r;
  r.tip_radius = tip_radius > 0.0 ? tip_radius : 1.5 * l;
  r.advance = 0.75 * l;
  r.speed_limit = 0.6 * m.rayleigh_speed();
  const double toughness = std::sqrt(m.material.youngs_modulus * m.material.fracture_energy / r.tip_radius);
  r.tip_strength = std::min(m.material.strength, kStretchMean * toughness);
  r.tip_bending_strength = std::min(m.material.strength, bending_mean(m.material.poisson_ratio) * toughness);
  r.branch_spacing = 8.0 * l, r.tip_clearance = 2.5 * l, r.parallel_clearance = 4.0 * l, r.join = l;
  r.turn = 10.0 * std::numbers::pi / 180.0;
  r.branch_ratio = std::numbers::sqrt2;
  r.branch_angle = 28.0 * std::numbers::pi / 180.0;
  r.faces = {0.05 * m.thickness, kCrushing * m.material.strength};
  return r;
}

int crack_interval(const CrackRules& r, double dt) {
  return std::max(1, static_cast<int>(0.5 * r.advance / (r.speed_limit * dt)));
}

int grow_cracks(const ShellModel& m, ShellState& s, const CrackRules& r, double time, double dt,
                std::uint64_t& random) {
  int inserted = grow_tips(m, s, r, time, dt);
  inserted += nucleate(m, s, r, time, random);
  if (!s.interlocks.empty()) release_interlocks(m, s, r.faces, false);
  return inserted;
}

}  // namespace sunder::shell
