#include "shell/solver/cracking/energy_release.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "shell/mechanics/layers.h"

namespace sunder::shell {
namespace {

Vec3 vec(const Vector<double>& a) { return {a.x, a.y, a.z}; }

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

void find_points(const ShellModel& m, const ShellState& s, const ReleaseLook& look, ReleaseRing& ring) {
  ring.look = look, ring.edges = static_cast<int>(s.cracks.graph.edges().size());
  ring.points.clear();
  const RowTables& t = m.tables;
  const std::array<Vec3, 2> e = advances_at_rest(m, look);
  points_within(m, look.tip, look.outer, 1, 1, [&](int block, int lane, const Vec2& offset, double) {
    ReleaseRing::Point p;
    p.gathered = s.cracked.point_of.empty() ? -1 : s.cracked.point_of[static_cast<std::size_t>(block) * t.lanes + lane];
    if (p.gathered >= 0) {
      p.own = s.cracked.gathered[p.gathered];
    } else {
      p.own.block = block, p.own.lane = lane, p.own.kind = PointKind::kQuadratic;
      p.own.area = t.metric[t.at(block, kMetricFields, kArea, lane)];
      patch_functions(m.patch, look.tip + offset, t.stride, p.own.functions);
    }
    if (p.own.kind == PointKind::kDead) return;
    const Derivatives<double> d = gather(t, p.own, m.rest);
    const Forms<double> f = surface_forms(d);
    p.own.metric = {f.a, f.b};
    p.offset = offset, p.chi = advance_at(offset, look.inner, look.outer);
    const double inverse = f.inverse_area * f.inverse_area;
    for (int k = 0; k < 2; ++k) {
      const double eu = e[k].dot(vec(d.u)), ev = e[k].dot(vec(d.v));
      p.along[k] = inverse * Vec2(f.a.c22 * eu - f.a.c12 * ev, f.a.c11 * ev - f.a.c12 * eu);
      p.up[k] = e[k].dot(vec(f.normal));
    }
    ring.points.push_back(std::move(p));
  });
}

// Whether the points are still those, with the same functions.
bool holds(const ShellModel& m, const ShellState& s, const ReleaseLook& look, const ReleaseRing& ring) {
  if (!(ring.look == look)) return false;
  const Vec2 pad = Vec2::Constant(look.outer) + kLargestSupport * Vec2(m.spacing_u, m.spacing_v);
  bool same = true;
  s.cracks.graph.near_since(look.tip - pad, look.tip + pad, ring.edges, [&](int) { same = false; });
  for (const ReleaseRing::Point& p : ring.points)
    if (p.gathered >= 0 && s.cracked.gathered[p.gathered].stamp != p.own.stamp) return false;
  return same;
}

// The present state of one point.
struct Present {
  const ReleaseRing::Point* at = nullptr;
  Derivatives<double> d{};
  Forms<double> f{};
  Resultants<double> r{};
  std::array<Vec3, 2> w;  // the advances pushed forward
  // velocity, its changes along u and v, acceleration
  Vec3 v = Vec3::Zero(), vu = Vec3::Zero(), vv = Vec3::Zero(), acceleration = Vec3::Zero();
};

// False where the point bears nothing.
bool look_at(const ShellModel& m, const ShellState& s, const ReleaseRing::Point& p, Present& now) {
  const RowTables& t = m.tables;
  now = {};
  now.at = &p, now.d = gather(t, p.own, s.motion.x), now.f = surface_forms(now.d);
  const bool flat = p.own.kind == PointKind::kLinear;
  if (flat) now.f.b = p.own.metric.b;
  if (!bears(now.f, p.own.metric, t.layers)) return false;
  now.r = integrate_layers<double, true>(now.f, p.own.metric, t.layers, t.elasticity);
  if (flat) now.r.m = {0.0, 0.0, 0.0};
  for (int k = 0; k < 2; ++k) now.w[k] = vec(now.d.u) * p.along[k].x() + vec(now.d.v) * p.along[k].y();
  for (const GatheredFunction& g : p.own.functions) {
    const Vec3 v = s.velocity(g.slot);
    now.v += g.n[0] * v, now.vu += g.n[1] * v, now.vv += g.n[2] * v;
    now.acceleration += g.n[0] * s.motion.inverse_mass[g.slot] * s.at(s.motion.force, g.slot);
  }
  return std::isfinite(now.r.energy);
}

// The linear field nearest to the advance pushed forward: at the tip, and its change along u and along v.
struct LinearField {
  Vec3 middle, u, v;
};
LinearField nearest_field(const std::vector<Present>& points, int k) {
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero(), right = Eigen::Matrix3d::Zero();
  for (const Present& p : points) {
    const double weight = p.at->own.area * p.at->chi.slope.norm();
    const Vec3 basis(1.0, p.at->offset.x(), p.at->offset.y());
    square += weight * basis * basis.transpose(), right += weight * basis * p.w[k].transpose();
  }
  const Eigen::Matrix3d fit = square.ldlt().solve(right);
  return {fit.row(0).transpose(), fit.row(1).transpose(), fit.row(2).transpose()};
}

// What a point adds to the integrals of advance k, for each of its area [N/m].
double density_at(const Present& p, int k, const LinearField& field, double mass_per_area) {
  const VirtualAdvance& chi = p.at->chi;
  const Vec2& e = p.at->along[k];
  const Vec3& w = p.w[k];
  const Vec3 u = vec(p.d.u), v = vec(p.d.v), normal = vec(p.f.normal);
  const double cu = chi.slope.x(), cv = chi.slope.y();
  const Sym2<double>&n = p.r.n, &m = p.r.m, &b = p.f.b, &rest = p.at->own.metric.b;
  const Vec3 f = field.middle + field.u * p.at->offset.x() + field.v * p.at->offset.y();
  const Vec3 fu = cu * f + chi.value * field.u, fv = cv * f + chi.value * field.v;  // of chi f
  const Vec3 fuu = chi.uu * f + 2.0 * cu * field.u, fvv = chi.vv * f + 2.0 * cv * field.v,
             fuv = chi.uv * f + cu * field.v + cv * field.u;
  const double inverse = p.f.inverse_area * p.f.inverse_area;
  const Vec3 du = inverse * (u * p.f.a.c22 - v * p.f.a.c12), dv = inverse * (v * p.f.a.c11 - u * p.f.a.c12);
  const auto bend = [&](const Vec3& second, const Vector<double>& x) {
    return (second - vec(x).dot(du) * fu - vec(x).dot(dv) * fv).dot(normal);
  };
  const Vec3 wu = cu * w - fu, wv = cv * w - fv;
  const double stretched = n.c11 * wu.dot(u) + n.c22 * wv.dot(v) + n.c12 * (wu.dot(v) + wv.dot(u)) +
                           p.at->up[k] * chi.value * (n.c11 * rest.c11 + n.c22 * rest.c22 + 2.0 * n.c12 * rest.c12);
  const double b1 = b.c11 * e.x() + b.c12 * e.y(), b2 = b.c12 * e.x() + b.c22 * e.y();
  const double bent = m.c11 * (2.0 * b1 * cu - bend(fuu, p.d.uu)) + m.c22 * (2.0 * b2 * cv - bend(fvv, p.d.vv)) +
                      2.0 * m.c12 * (b1 * cv + b2 * cu - bend(fuv, p.d.uv));
  const double stored = p.r.energy + 0.5 * mass_per_area * p.v.squaredNorm();
  const double moving = p.acceleration.dot(w - f) - p.v.dot(e.x() * p.vu + e.y() * p.vv);
  return stretched - bent - stored * e.dot(chi.slope) + chi.value * mass_per_area * moving;
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
  Present now;
  for (const ReleaseRing::Point& p : ring.points)
    if (look_at(m, s, p, now)) points.push_back(now);
  if (points.size() < 4) return Vec2::Zero();  // fewer fix no linear field
  Vec2 sum = Vec2::Zero();
  for (int k = 0; k < 2; ++k) {
    const LinearField field = nearest_field(points, k);
    for (const Present& p : points)
      sum[k] += p.at->own.area * density_at(p, k, field, m.material.density * m.thickness);
  }
  return sum / m.thickness;
}

std::optional<Vec2> tip_release(const ShellModel& m, const ShellState& s, const Tip& tip, ReleaseRing& ring) {
  if (s.yields() || s.weakens() || m.laminated() || tip.grown < tip.flaw) return {};
  const double outer = free_radius(m, s, tip, kReleaseOuter * m.spacing);
  if (outer < kReleaseLeast * m.spacing) return {};
  return energy_release_at(m, s, {tip.p, tip.direction, kReleaseInner * outer, outer}, ring);
}

double faces_apart(const ShellModel& m, const ShellState& s, const ReleaseRing& ring) {
  struct Side {
    Vec3 place = Vec3::Zero(), normal = Vec3::Zero();
    double weight = 0.0;
  } sides[2];
  const Vec2& d = ring.look.direction;
  for (const ReleaseRing::Point& p : ring.points) {
    const double along = d.dot(p.offset), left = d.x() * p.offset.y() - d.y() * p.offset.x();
    if (along > -ring.look.inner) continue;
    Vec3 place = Vec3::Zero();
    for (const GatheredFunction& f : p.own.functions) place += f.n[0] * s.position(f.slot);
    Side& side = sides[left > 0.0];
    side.place += p.own.area * place, side.weight += p.own.area;
    side.normal += p.own.area * vec(surface_forms(gather(m.tables, p.own, s.motion.x)).normal);
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
