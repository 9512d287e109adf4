#include "shell/solver/contact/rigid_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "shell/solver/contact/hertz.h"

namespace sunder::shell {
namespace {

// speed [m/s] at which an overlap is taken back: a body born in overlap gains no energy
constexpr double kFastestRecovery = 0.01;
constexpr double kSlack = 1e-9;  // of the thickness: round-off of distances
constexpr int kTile = 8;         // elements per side of a tile, the coarse unit of the search

Vec3 position(const ShellState& s, const std::vector<GatheredFunction>& functions) {
  Vec3 x = Vec3::Zero();
  for (const auto& f : functions) x += f.n[0] * s.position(f.slot);
  return x;
}
Vec3 velocity(const ShellState& s, const std::vector<GatheredFunction>& functions) {
  Vec3 v = Vec3::Zero();
  for (const auto& f : functions) v += f.n[0] * s.velocity(f.slot);
  return v;
}

// Applies an impulse and books its work.
void push(ShellState& s, Proxy& body, const std::vector<GatheredFunction>& functions, const Vec3& x, const Vec3& before,
          const Vec3& j, double dt) {
  apply_impulse(s, body, functions, x, j);
  const Vec3 after = velocity(s, functions) - body.velocity_at(x);
  Vec3 back = Vec3::Zero();  // change of the sample's velocity by half a kick
  for (const auto& f : functions)
    back += (f.n[0] * 0.5 * dt * s.motion.inverse_mass[f.slot]) * s.at(s.motion.force, f.slot);
  s.book.contact -= j.dot(0.5 * (before + after) - back);
  s.book.external += body.work(x, j);
}

}  // namespace

void apply_impulse(ShellState& s, Proxy& body, const std::vector<GatheredFunction>& functions, const Vec3& x,
                   const Vec3& j) {
  for (const auto& f : functions) {
    s.add_velocity(f.slot, (f.n[0] * s.motion.inverse_mass[f.slot]) * j);
    s.pass_to_supports(f.slot, f.n[0] * j);
    s.count_contact(f.slot, f.n[0] * j);
    body.shell_linear += f.n[0] * j;
    const Vec3 arm = s.position(f.slot) - body.body.motion.position;
    body.shell_angular += arm.cross(f.n[0] * j);
    body.moment_sum += arm.norm() * std::abs(f.n[0]) * j.norm();
  }
  s.count_body(body.body.id, j);
  body.impulse_sum += j.norm();
  body.apply(x, -j);
}

void refresh_candidates(const ShellModel& m, const ShellState& s, const std::vector<Proxy>& bodies,
                        const std::vector<ContactCoefficients>& coefficients, double dt, ContactCandidates& c) {
  const RowTables& t = m.tables;
  c.age = 0;
  c.of_body.resize(bodies.size());
  if (bodies.empty()) return;
  double speed = 0.0;
  for (int i = 0; i < m.control_points(); ++i) speed = std::max(speed, s.velocity(t.slot(i)).squaredNorm());
  speed = std::sqrt(speed);
  const int tiles_u = (t.spans_u + kTile - 1) / kTile, tiles_v = (t.spans_v + kTile - 1) / kTile;
  std::vector<Eigen::AlignedBox3d>& boxes = c.boxes;
  boxes.assign(static_cast<std::size_t>(tiles_u) * tiles_v, Eigen::AlignedBox3d());
  for (int tv = 0; tv < tiles_v; ++tv)
    for (int tu = 0; tu < tiles_u; ++tu)
      for (int j = tv * kTile; j < std::min(t.rows, (tv + 1) * kTile + t.degree); ++j)
        for (int i = tu * kTile; i < std::min(t.columns, (tu + 1) * kTile + t.degree); ++i)
          if (!s.motion.detached[j * t.stride + i]) boxes[tv * tiles_u + tu].extend(s.position(j * t.stride + i));
  if (++c.refresh == 0) c.places.assign(c.places.size(), {}), c.refresh = 1;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    auto& list = c.of_body[b];
    list.clear();
    const Proxy& body = bodies[b];
    const double reach = body.turning_speed();
    // The margin is twice the travel until the next refresh, since control points may speed up.
    const double travel = 2.0 * dt * (speed + body.body.motion.velocity.norm() + reach);  // in one substep
    double margin = m.thickness + kContactRefresh * travel;
    if (coefficients[b].hertz > 0.0) margin += m.longest_element;  // Hertz contact acts between samples
    const Vec3 centre = body.body.motion.position;
    for (int tile = 0; tile < tiles_u * tiles_v; ++tile) {
      if (boxes[tile].isEmpty()) continue;
      const double pad = margin + 2.0 * m.spacing;  // cracked samples may lie outside their control points
      if (std::isfinite(body.radius())) {
        const double r = body.radius() + pad;
        if (boxes[tile].squaredExteriorDistance(centre) > r * r) continue;
      } else {
        double low = std::numeric_limits<double>::infinity();
        for (int k = 0; k < 8; ++k)
          low = std::min(low, body.distance(boxes[tile].corner(static_cast<Eigen::AlignedBox3d::CornerType>(k))).value);
        if (low > pad) continue;
      }
      c.places.resize(static_cast<std::size_t>(t.blocks()) * t.lanes);  // allocated when a body first comes near
      const int tu = tile % tiles_u, tv = tile / tiles_u;
      for (int f = tv * kTile; f < std::min(t.spans_v, (tv + 1) * kTile); ++f)
        for (int lane = tu * kTile; lane < std::min(t.spans_u, (tu + 1) * kTile); ++lane)
          for (int sub = 0; sub < t.gauss * t.gauss; ++sub) {
            const int block = f * t.gauss * t.gauss + sub;
            if (t.metric[t.at(block, kMetricFields, kArea, lane)] == 0.0) continue;
            ContactCandidates::Place& q = c.places[static_cast<std::size_t>(block) * t.lanes + lane];
            if (q.refresh != c.refresh) {
              sample_functions(m, s, block, lane, c.functions);
              q.refresh = c.refresh, q.there = !c.functions.empty() && !s.motion.detached[c.functions[0].slot];
              if (q.there) q.x = position(s, c.functions);
            }
            if (!q.there || (q.x - centre).norm() > body.radius() + margin) continue;
            const double gap = body.distance(q.x).value;
            if (gap >= margin) continue;
            const double free = std::max(0.0, gap - 0.5 * m.thickness);
            const int first = static_cast<int>(std::min(free / travel, static_cast<double>(kContactRefresh)));
            list.push_back({block, lane, first, body.known(q.x, gap)});
          }
    }
  }
}

int contact(const ShellModel& m, ShellState& s, std::vector<Proxy>& bodies,
            const std::vector<ContactCoefficients>& coefficients, ContactCandidates& candidates, double dt,
            double kicked) {
  int touching = 0;
  thread_local std::vector<GatheredFunction> functions;
  for (std::size_t b = 0; b < candidates.of_body.size(); ++b) {
    if (candidates.of_body[b].empty()) continue;
    Proxy& body = bodies[b];
    if (coefficients[b].hertz > 0.0) {
      touching += hertz_contact(m, s, body, coefficients[b].hertz, candidates.of_body[b], kicked);
      continue;
    }
    for (auto& candidate : candidates.of_body[b]) {
      if (candidates.age <= candidate.first) continue;
      sample_functions(m, s, candidate.block, candidate.lane, functions);  // a crack may have changed them
      if (functions.empty() || s.motion.detached[functions[0].slot]) continue;
      const Vec3 x = position(s, functions);
      if (body.surely_beyond(x, candidate.known, 0.5 * m.thickness, kSlack * m.thickness)) continue;
      const Proxy::Distance middle = body.distance(x);
      candidate.known = body.known(x, middle.value);
      if (middle.value > 0.5 * m.thickness) continue;
      // The face towards the body is half a thickness from the mid-surface, along the shell's own normal.
      Vec3 tu = Vec3::Zero(), tv = Vec3::Zero();
      const bool gathered = functions.front().n[1] != 0.0 || functions.size() != m.patch.functions();
      if (gathered) {
        for (const auto& f : functions) tu += f.n[1] * s.position(f.slot), tv += f.n[2] * s.position(f.slot);
      } else {
        const ShapeFunctions n =
            m.patch.shape_functions(gauss_point(m.patch, m.tables, candidate.block, candidate.lane).parameter);
        for (int k = 0; k < n.count(); ++k) {
          const Vec3 x = s.position(n.row(k) * m.tables.stride + n.column(k));
          tu += n.u[k] * x, tv += n.v[k] * x;
        }
      }
      Vec3 normal = tu.cross(tv).normalized();
      if (normal.dot(middle.normal) > 0.0) normal = -normal;  // towards the body
      const Vec3 face = x + 0.5 * m.thickness * normal;
      const Proxy::Distance gap = body.distance(face);
      if (gap.value >= 0.0) continue;
      ++touching;
      // The impulse acts on both sides at the mid-surface point, where the shape functions place it. Linear and angular
      // momentum then close to round-off.
      const Vec3 before = velocity(s, functions) - body.velocity_at(x);
      Mat3 inverse = body.inverse_mass_at(x);
      for (const auto& f : functions) inverse.diagonal().array() += f.n[0] * f.n[0] * s.motion.inverse_mass[f.slot];
      if (inverse.trace() <= 0.0) continue;
      // A bouncing sample leaves the overlap by itself. A recovery speed on top would add energy, most to slow ones.
      const double recovered = std::min(body.recovery * -gap.value / dt, kFastestRecovery);
      const double bounce = -coefficients[b].restitution * gap.normal.dot(before);
      const Vec3 wanted =
          bounce >= recovered ? Vec3::Zero() : Vec3(recovered * gap.normal);  // of the velocity afterwards
      const Vec3 j =
          contact_impulse(gap.normal, before - wanted, inverse, coefficients[b].friction, coefficients[b].restitution);
      if (j.isZero(0.0)) continue;
      push(s, body, functions, x, before, j, dt);
    }
  }
  return touching;
}

}  // namespace sunder::shell
