#include "shell/solver/cracking/energy_release.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "coupler/core/dense.h"
#include "shell/mechanics/layers.h"

namespace sunder::shell {
namespace {

Vec3 vec(const Vector<double>& a) { return {a.x, a.y, a.z}; }

Vector<Pack> operator+(const Vector<Pack>& a, const Vector<Pack>& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vector<Pack> operator-(const Vector<Pack>& a, const Vector<Pack>& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vector<Pack> operator*(const Pack& a, const Vector<Pack>& b) { return {a * b.x, a * b.y, a * b.z}; }
Vector<Pack> in_all_lanes(const Vec3& a) { return {splat<Pack>(a.x()), splat<Pack>(a.y()), splat<Pack>(a.z())}; }
double sum_of(const Pack& a) {
  double sum = 0.0;
  for (int i = 0; i < kLanes; ++i) sum += a[i];
  return sum;
}

constexpr double kTaperStep = 0.05;  // [spacings]: half of the difference that tells how the thickness changes

// The virtual advance at a point: chi, its first and its second derivatives.
struct VirtualAdvance {
  double value = 1.0;
  Vec2 slope = Vec2::Zero();
  double uu = 0.0, vv = 0.0, uv = 0.0;
};

// A polynomial with two continuous derivatives between the radii.
VirtualAdvance advance_at(const Vec2& d, double inner, double outer) {
  VirtualAdvance a;
  const double r = d.norm(), width = outer - inner, s = (r - inner) / width;
  if (s <= 0.0) return a;
  if (s >= 1.0) return {0.0};
  a.value = 1.0 - s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
  const double first = -30.0 * s * s * (1.0 - s) * (1.0 - s) / width,
               second = -60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (width * width);
  const Vec2 e = d / r;
  a.slope = first * e;
  a.uu = second * e.x() * e.x() + first / r * e.y() * e.y();
  a.vv = second * e.y() * e.y() + first / r * e.x() * e.x();
  a.uv = (second - first / r) * e.x() * e.y();
  return a;
}

// The directions along and across at rest, at the tip.
std::array<Vec3, 2> advances_at_rest(const ShellModel& m, const ReleaseLook& look) {
  GatheredPoint tip;
  tip.functions = patch_functions(m.patch, look.tip, m.tables.stride);
  const Derivatives<double> d = gather(m.tables, tip, m.rest);
  const Vec3 along = (vec(d.u) * look.direction.x() + vec(d.v) * look.direction.y()).normalized();
  return {along, vec(surface_forms(d).normal).cross(along)};
}

struct RingPoint {
  GatheredPoint own;  // functions and forms at rest
  Vec2 offset;
  double thick = 1.0;  // factor of the thickness
};

// Writes a point into one lane of a pack.
void fill_lane(const ShellModel& m, const ReleaseLook& look, const std::array<Vec3, 2>& e, const RingPoint& p, int lane,
               ReleasePack& pack, ReleaseRing& ring) {
  const Derivatives<double> d = gather(m.tables, p.own, m.rest);
  const Forms<double> f = surface_forms(d);
  const VirtualAdvance chi = advance_at(p.offset, look.inner, look.outer);
  pack.offset.u[lane] = p.offset.x(), pack.offset.v[lane] = p.offset.y();
  pack.chi[lane] = chi.value, pack.slope.u[lane] = chi.slope.x(), pack.slope.v[lane] = chi.slope.y();
  pack.chi_uu[lane] = p.thick * chi.uu, pack.chi_vv[lane] = p.thick * chi.vv, pack.chi_uv[lane] = p.thick * chi.uv;
  pack.bent_slope.u[lane] = p.thick * chi.slope.x(), pack.bent_slope.v[lane] = p.thick * chi.slope.y();
  pack.curvature.c11[lane] = f.b.c11 / p.thick, pack.curvature.c22[lane] = f.b.c22 / p.thick;
  pack.curvature.c12[lane] = f.b.c12 / p.thick;
  pack.rest.a.c11[lane] = f.a.c11, pack.rest.a.c22[lane] = f.a.c22, pack.rest.a.c12[lane] = f.a.c12;
  pack.rest.b.c11[lane] = f.b.c11, pack.rest.b.c22[lane] = f.b.c22, pack.rest.b.c12[lane] = f.b.c12;
  pack.linear[lane] = p.own.kind == PointKind::kLinear ? -1 : 0;
  const double inverse = f.inverse_area * f.inverse_area;
  for (int k = 0; k < 2; ++k) {
    const double eu = e[k].dot(vec(d.u)), ev = e[k].dot(vec(d.v));
    pack.along[k].u[lane] = inverse * (f.a.c22 * eu - f.a.c12 * ev);
    pack.along[k].v[lane] = inverse * (f.a.c11 * ev - f.a.c12 * eu);
    pack.up[k][lane] = e[k].dot(vec(f.normal));
    if (!m.varies()) continue;
    const Vec2 at = look.tip + p.offset, step(kTaperStep * m.spacing_u, kTaperStep * m.spacing_v);
    const auto change = [&](int d) {
      const KnotVector& knots = d == 0 ? m.patch.knots_u : m.patch.knots_v;
      Vec2 before = at, after = at;  // beyond the border there is no thickness
      before[d] = std::max(at[d] - step[d], knots.begin()), after[d] = std::min(at[d] + step[d], knots.end());
      return (m.thickness_at(after) - m.thickness_at(before)) / ((after[d] - before[d]) * m.thickness * p.thick);
    };
    pack.taper[k][lane] = pack.along[k].u[lane] * change(0) + pack.along[k].v[lane] * change(1);
  }
  for (std::size_t i = 0; i < pack.functions; ++i) {
    ReleaseRing::Function& to = ring.functions[pack.begin + i];
    const bool has = i < p.own.functions.size();
    to.slot[lane] = p.own.functions[has ? i : 0].slot;
    for (int k = 0; k < 6; ++k) to.n[k][lane] = has ? p.own.functions[i].n[k] : 0.0;
  }
}

void find_points(const ShellModel& m, const ShellState& s, const ReleaseLook& look, ReleaseRing& ring) {
  ring.look = look, ring.edges = static_cast<int>(s.cracks.graph.edges().size());
  ring.gathered.clear(), ring.packs.clear(), ring.functions.clear();
  const RowTables& t = m.tables;
  std::vector<RingPoint> points;
  points_within(m, look.tip, look.outer, 1, 1, [&](int block, int lane, const Vec2& offset, double) {
    RingPoint p;
    const int gathered =
        s.cracked.point_of.empty() ? -1 : s.cracked.point_of[static_cast<std::size_t>(block) * t.lanes + lane];
    if (gathered >= 0) {
      p.own = s.cracked.gathered[gathered];
      ring.gathered.push_back({gathered, p.own.stamp});
    } else {
      p.own.area = t.metric[t.at(block, kMetricFields, kArea, lane)], p.own.kind = PointKind::kQuadratic;
      patch_functions(m.patch, look.tip + offset, t.stride, p.own.functions);
      thicken(p.own.functions, t.thickness_factor(block, lane));
    }
    p.offset = offset, p.thick = t.thickness_factor(block, lane);
    if (p.own.kind != PointKind::kDead && !p.own.functions.empty()) points.push_back(std::move(p));
  });
  std::stable_sort(points.begin(), points.end(), [](const RingPoint& a, const RingPoint& b) {
    return a.own.functions.size() < b.own.functions.size();
  });
  const std::array<Vec3, 2> e = advances_at_rest(m, look);
  for (std::size_t first = 0; first < points.size(); first += kLanes) {
    ReleasePack pack;
    pack.count = static_cast<int>(std::min<std::size_t>(kLanes, points.size() - first));
    pack.begin = ring.functions.size(), pack.functions = points[first + pack.count - 1].own.functions.size();
    ring.functions.resize(pack.begin + pack.functions);
    for (int lane = 0; lane < kLanes; ++lane) {
      const RingPoint& p = points[first + (lane < pack.count ? lane : 0)];
      fill_lane(m, look, e, p, lane, pack, ring);
      pack.area[lane] = lane < pack.count ? p.own.area : 0.0;
    }
    ring.packs.push_back(pack);
  }
}

// Whether the points are still those, with the same functions.
bool holds(const ShellModel& m, const ShellState& s, const ReleaseLook& look, const ReleaseRing& ring) {
  if (!(ring.look == look)) return false;
  const Vec2 pad = Vec2::Constant(look.outer) + kLargestSupport * Vec2(m.spacing_u, m.spacing_v);
  bool same = true;
  s.cracks.graph.near_since(look.tip - pad, look.tip + pad, ring.edges, [&](int) { same = false; });
  for (const ReleaseRing::Gathered& p : ring.gathered)
    if (s.cracked.gathered[p.number].stamp != p.stamp) return false;
  return same;
}

// Values of one lane each at `slot` of an array [3][component stride].
Vector<Pack> at_slots(const std::vector<double>& values, const std::array<int, kLanes>& slot) {
  const std::size_t stride = values.size() / 3;
  const double* const a = values.data();
  Vector<Pack> r;
  for (int i = 0; i < kLanes; ++i) r.x[i] = a[slot[i]], r.y[i] = a[stride + slot[i]], r.z[i] = a[2 * stride + slot[i]];
  return r;
}

void add(Vector<Pack>& to, const Pack& n, const Vector<Pack>& x) { to.x += n * x.x, to.y += n * x.y, to.z += n * x.z; }

Derivatives<Pack> derivatives_of(const ShellState& s, const ReleaseRing& ring, const ReleasePack& pack) {
  Derivatives<Pack> d{};
  for (std::size_t i = pack.begin; i < pack.begin + pack.functions; ++i) {
    const ReleaseRing::Function& f = ring.functions[i];
    const Vector<Pack> x = at_slots(s.motion.x, f.slot);
    add(d.u, f.n[1], x), add(d.v, f.n[2], x), add(d.uu, f.n[3], x), add(d.vv, f.n[4], x), add(d.uv, f.n[5], x);
  }
  return d;
}

// The present state of a pack of points.
struct Present {
  const ReleasePack* at;
  IntPack sound;  // lanes that bear
  Derivatives<Pack> d;
  Forms<Pack> f;
  Resultants<Pack> r;
  std::array<Vector<Pack>, 2> w;  // the advances pushed forward
  // velocity, its changes along u and v, acceleration
  Vector<Pack> v{}, vu{}, vv{}, acceleration{};
};

Present look_at(const ShellModel& m, const ShellState& s, const ReleaseRing& ring, const ReleasePack& pack) {
  const RowTables& t = m.tables;
  Present now;
  now.at = &pack, now.d = derivatives_of(s, ring, pack), now.f = surface_forms(now.d);
  const Pack none{};
  Sym2<Pack>&b = now.f.b, &moment = now.r.m;
  const Sym2<Pack>& rest = pack.rest.b;
  b = {select(pack.linear, rest.c11, b.c11), select(pack.linear, rest.c22, b.c22),
       select(pack.linear, rest.c12, b.c12)};
  now.sound = bears(now.f, pack.rest, t.layers) & (pack.area > 0.0);
  now.r = integrate_layers<Pack, true>(now.f, pack.rest, t.layers, t.elasticity);
  moment = {select(pack.linear, none, moment.c11), select(pack.linear, none, moment.c22),
            select(pack.linear, none, moment.c12)};
  for (int i = 0; i < kLanes; ++i)
    if (!std::isfinite(now.r.energy[i])) now.sound[i] = 0;
  for (int k = 0; k < 2; ++k) now.w[k] = pack.along[k].u * now.d.u + pack.along[k].v * now.d.v;
  for (std::size_t i = pack.begin; i < pack.begin + pack.functions; ++i) {
    const ReleaseRing::Function& f = ring.functions[i];
    const Vector<Pack> v = at_slots(s.motion.v, f.slot);
    add(now.v, f.n[0], v), add(now.vu, f.n[1], v), add(now.vv, f.n[2], v);
    Pack per_mass;
    for (int lane = 0; lane < kLanes; ++lane) per_mass[lane] = s.motion.inverse_mass[f.slot[lane]];
    add(now.acceleration, f.n[0] * per_mass, at_slots(s.motion.force, f.slot));
  }
  return now;
}

// The linear field nearest to the advance pushed forward: at the tip, and its change along u and along v. `spacing` [m]
// makes the equations free of units: which of them is solved first must not depend on the unit.
struct LinearField {
  Vector<Pack> middle, u, v;
};
LinearField nearest_field(const std::vector<Present>& points, int k, double spacing) {
  Pack square[6] = {};
  Vector<Pack> right[3] = {};
  for (const Present& p : points) {
    const ReleasePack& at = *p.at;
    const Pack steep = square_root(at.slope.u * at.slope.u + at.slope.v * at.slope.v);
    const Pack weight = select(p.sound, at.area * steep, Pack{}), u = weight * at.offset.u, v = weight * at.offset.v;
    square[0] += weight, square[1] += u, square[2] += v;
    square[3] += u * at.offset.u, square[4] += u * at.offset.v, square[5] += v * at.offset.v;
    add(right[0], weight, p.w[k]), add(right[1], u, p.w[k]), add(right[2], v, p.w[k]);
  }
  Eigen::Matrix3d a, b;
  double sums[6];
  for (int i = 0; i < 6; ++i) sums[i] = sum_of(square[i]);
  a << sums[0], sums[1], sums[2], sums[1], sums[3], sums[4], sums[2], sums[4], sums[5];
  for (int i = 0; i < 3; ++i) b.row(i) << sum_of(right[i].x), sum_of(right[i].y), sum_of(right[i].z);
  const Eigen::Vector3d free(1.0, 1.0 / spacing, 1.0 / spacing);
  const Eigen::Matrix3d fit =
      free.asDiagonal() * solved_symmetric(free.asDiagonal() * a * free.asDiagonal(), free.asDiagonal() * b);
  return {in_all_lanes(fit.row(0)), in_all_lanes(fit.row(1)), in_all_lanes(fit.row(2))};
}

// What points add to the integrals of advance k, for each of their area [N/m]. Where the thickness varies an area
// changes its energy by the thickness alone as well, that of bending with the third power.
template <bool kVaries>
Pack density_at(const Present& p, int k, const LinearField& field, double mass_per_area) {
  const ReleasePack& at = *p.at;
  const Vector2<Pack>& e = at.along[k];
  const Vector<Pack>& w = p.w[k];
  const Vector<Pack>&u = p.d.u, &v = p.d.v, &normal = p.f.normal;
  const Pack &cu = at.slope.u, &cv = at.slope.v;
  const Sym2<Pack>&n = p.r.n, &m = p.r.m, &b = p.f.b, &rest = at.curvature;
  const Vector<Pack> f = field.middle + at.offset.u * field.u + at.offset.v * field.v;
  const Vector<Pack> fu = cu * f + at.chi * field.u, fv = cv * f + at.chi * field.v;  // of chi f
  const Pack &su = at.bent_slope.u, &sv = at.bent_slope.v;
  const Vector<Pack> fuu = at.chi_uu * f + 2.0 * su * field.u, fvv = at.chi_vv * f + 2.0 * sv * field.v,
                     fuv = at.chi_uv * f + su * field.v + sv * field.u;
  const Pack inverse = p.f.inverse_area * p.f.inverse_area;
  const Vector<Pack> du = inverse * (p.f.a.c22 * u - p.f.a.c12 * v), dv = inverse * (p.f.a.c11 * v - p.f.a.c12 * u);
  const auto bend = [&](const Vector<Pack>& second, const Vector<Pack>& x) {
    return dot(second - dot(x, du) * fu - dot(x, dv) * fv, normal);
  };
  const Vector<Pack> wu = cu * w - fu, wv = cv * w - fv;
  const Pack stretched = n.c11 * dot(wu, u) + n.c22 * dot(wv, v) + n.c12 * (dot(wu, v) + dot(wv, u)) +
                         at.up[k] * at.chi * (n.c11 * rest.c11 + n.c22 * rest.c22 + 2.0 * n.c12 * rest.c12);
  const Pack b1 = b.c11 * e.u + b.c12 * e.v, b2 = b.c12 * e.u + b.c22 * e.v;
  const Pack bent = m.c11 * (2.0 * b1 * cu - bend(fuu, p.d.uu)) + m.c22 * (2.0 * b2 * cv - bend(fvv, p.d.vv)) +
                    2.0 * m.c12 * (b1 * cv + b2 * cu - bend(fuv, p.d.uv));
  const Pack stored = p.r.energy + 0.5 * mass_per_area * dot(p.v, p.v);
  const Pack moving = dot(p.acceleration, w - f) - dot(p.v, e.u * p.vu + e.v * p.vv);
  const Pack density = stretched - bent - stored * (e.u * cu + e.v * cv) + at.chi * mass_per_area * moving;
  if constexpr (!kVaries) return density;
  const Sym2<Pack>& flat = at.rest.b;
  const Pack thicker =
      stored - m.c11 * (b.c11 - flat.c11) - m.c22 * (b.c22 - flat.c22) - 2.0 * m.c12 * (b.c12 - flat.c12);
  return density - at.chi * at.taper[k] * thicker;
}

// Whether a point lies behind a tip, within kWake of its course, where its own crack is.
bool behind(const Tip& tip, const Vec2& p, double spacing) {
  const Vec2 d = p - tip.p;
  const double across = std::abs(d.x() * tip.direction.y() - d.y() * tip.direction.x());
  return d.dot(tip.direction) <= kWakeMargin * spacing && across <= std::sin(kWake) * d.norm() + kWakeMargin * spacing;
}

// The radius about a tip, at most `most`, within which there is no other tip, no other crack and no border.
double free_radius(const ShellModel& m, const ShellState& s, const Tip& tip, double most) {
  const auto &ku = m.patch.knots_u, &kv = m.patch.knots_v;
  double free =
      std::min({most, tip.p.x() - ku.begin(), ku.end() - tip.p.x(), tip.p.y() - kv.begin(), kv.end() - tip.p.y()});
  for (const Tip& other : s.cracks.tips)
    if (other.alive && other.vertex != tip.vertex) free = std::min(free, (other.p - tip.p).norm());
  s.cracks.graph.near(tip.p, tip.p, free, [&](int e) {
    const CrackEdge& c = s.cracks.graph.edges()[e];
    Vec2 foot;
    if (!behind(tip, c.a, m.spacing) || !behind(tip, c.b, m.spacing))
      free = std::min(free, s.cracks.graph.distance(tip.p, e, foot));
    return true;
  });
  return free;
}

}  // namespace

Vec2 energy_release_at(const ShellModel& m, const ShellState& s, const ReleaseLook& look) {
  ReleaseRing unknown;
  return energy_release_at(m, s, look, unknown);
}

Vec2 energy_release_at(const ShellModel& m, const ShellState& s, const ReleaseLook& look, ReleaseRing& ring) {
  if (!holds(m, s, look, ring)) find_points(m, s, look, ring);
  thread_local std::vector<Present> points;
  points.clear();
  int sound = 0;
  for (const ReleasePack& pack : ring.packs) {
    points.push_back(look_at(m, s, ring, pack));
    for (int i = 0; i < kLanes; ++i) sound += points.back().sound[i] != 0;
  }
  if (sound < 4) return Vec2::Zero();  // fewer fix no linear field
  Vec2 sum = Vec2::Zero();
  for (int k = 0; k < 2; ++k) {
    const LinearField field = nearest_field(points, k, m.spacing);
    Pack all{};
    const double mass_per_area = m.material.density * m.thickness;
    if (m.varies())
      for (const Present& p : points)
        all += select(p.sound, p.at->area * density_at<true>(p, k, field, mass_per_area), Pack{});
    else
      for (const Present& p : points)
        all += select(p.sound, p.at->area * density_at<false>(p, k, field, mass_per_area), Pack{});
    sum[k] = sum_of(all);
  }
  return sum / m.thickness_at(look.tip);
}

std::optional<Vec2> tip_release(const ShellModel& m, const ShellState& s, const Tip& tip, ReleaseRing& ring) {
  if (s.yields() || s.weakens() || m.laminated() || tip.grown < tip.flaw) return {};
  const double outer = free_radius(m, s, tip, kReleaseOuter * m.spacing);
  if (outer < kReleaseLeast * m.spacing) return {};
  return energy_release_at(m, s, {tip.p, tip.direction, kReleaseInner * outer, outer}, ring);
}

double faces_apart(const ShellState& s, const ReleaseRing& ring) {
  struct Side {
    Vec3 place = Vec3::Zero(), normal = Vec3::Zero();
    double weight = 0.0;
  } sides[2];
  const Vec2& d = ring.look.direction;
  for (const ReleasePack& pack : ring.packs) {
    Vector<Pack> place{};
    for (std::size_t i = pack.begin; i < pack.begin + pack.functions; ++i)
      add(place, ring.functions[i].n[0], at_slots(s.motion.x, ring.functions[i].slot));
    const Vector<Pack> normal = surface_forms(derivatives_of(s, ring, pack)).normal;
    for (int i = 0; i < pack.count; ++i) {
      const Vec2 offset(pack.offset.u[i], pack.offset.v[i]);
      const double along = d.dot(offset), left = d.x() * offset.y() - d.y() * offset.x(), area = pack.area[i];
      if (along > -ring.look.inner) continue;
      Side& side = sides[left > 0.0];
      side.place += area * Vec3(place.x[i], place.y[i], place.z[i]), side.weight += area;
      side.normal += area * Vec3(normal.x[i], normal.y[i], normal.z[i]);
    }
  }
  if (!(sides[0].weight > 0.0) || !(sides[1].weight > 0.0)) return 0.0;
  const Vec3 normal = (sides[0].normal / sides[0].weight + sides[1].normal / sides[1].weight).normalized();
  return std::abs(normal.dot(sides[1].place / sides[1].weight - sides[0].place / sides[0].weight));
}

double kink_factor(double turn) {
  const double half = std::cos(0.5 * turn), opened = 3.0 * std::cos(turn) - 1.0, sheared = std::sin(turn);
  const double kink = half * half * half * opened + 1.5 * half * sheared * sheared;
  return kink * kink / (opened * opened + sheared * sheared);
}

}  // namespace sunder::shell
