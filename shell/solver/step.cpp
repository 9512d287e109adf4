#include "shell/solver/step.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "shell/solver/hertz.h"

namespace sunder::shell {
namespace {

constexpr double kFastestRecovery = 0.01;  // of an overlap [m/s]: that of a body that was born in one makes no energy
constexpr int kTile = 8;                   // elements a side of a tile, the coarse unit of the search

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

// An impulse whose work is booked.
void push(ShellState& s, Proxy& body, const std::vector<GatheredFunction>& functions, const Vec3& x, const Vec3& before,
          const Vec3& j, double dt) {
  apply_impulse(s, body, functions, x, j);
  const Vec3 after = velocity(s, functions) - body.velocity_at(x);
  Vec3 back = Vec3::Zero();  // what half a kick has added to the sample's velocity
  for (const auto& f : functions) back += (f.n[0] * 0.5 * dt * s.inverse_mass[f.slot]) * s.at(s.force, f.slot);
  s.book.contact -= j.dot(0.5 * (before + after) - back);
}

}  // namespace

void apply_impulse(ShellState& s, Proxy& body, const std::vector<GatheredFunction>& functions, const Vec3& x,
                   const Vec3& j) {
  for (const auto& f : functions) {
    s.add_velocity(f.slot, (f.n[0] * s.inverse_mass[f.slot]) * j);
    body.shell_linear += f.n[0] * j;
    const Vec3 arm = s.position(f.slot) - body.body.motion.position;
    body.shell_angular += arm.cross(f.n[0] * j);
    body.moment_sum += arm.norm() * std::abs(f.n[0]) * j.norm();
  }
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
          if (!s.gone[j * t.stride + i]) boxes[tv * tiles_u + tu].extend(s.position(j * t.stride + i));
  if (++c.refresh == 0) c.places.assign(c.places.size(), {}), c.refresh = 1;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    auto& list = c.of_body[b];
    list.clear();
    const Proxy& body = bodies[b];
    const double reach = body.body.is_static ? 0.0 : body.body.angular_velocity().norm() * body.radius();
    // twice what both can move until the next refresh: control points may speed up meanwhile
    const double travel = 2.0 * dt * (speed + body.body.motion.velocity.norm() + reach);  // a substep
    double margin = m.thickness + kContactRefresh * travel;
    if (coefficients[b].hertz > 0.0) margin += m.longest_element;  // it acts between the samples
    const Vec3 centre = body.body.motion.position;
    for (int tile = 0; tile < tiles_u * tiles_v; ++tile) {
      if (boxes[tile].isEmpty()) continue;
      const double pad = margin + 2.0 * m.spacing;  // cracked points may lie outside their control points
      if (std::isfinite(body.radius())) {
        const double r = body.radius() + pad;
        if (boxes[tile].squaredExteriorDistance(centre) > r * r) continue;
      } else {
        double low = std::numeric_limits<double>::infinity();
        for (int k = 0; k < 8; ++k)
          low = std::min(low, body.distance(boxes[tile].corner(static_cast<Eigen::AlignedBox3d::CornerType>(k))).value);
        if (low > pad) continue;
      }
      c.places.resize(static_cast<std::size_t>(t.blocks()) * t.lanes);  // once a body has come near
      const int tu = tile % tiles_u, tv = tile / tiles_u;
      for (int f = tv * kTile; f < std::min(t.spans_v, (tv + 1) * kTile); ++f)
        for (int lane = tu * kTile; lane < std::min(t.spans_u, (tu + 1) * kTile); ++lane)
          for (int sub = 0; sub < t.gauss * t.gauss; ++sub) {
            const int block = f * t.gauss * t.gauss + sub;
            if (t.metric[t.at(block, kMetricFields, kArea, lane)] == 0.0) continue;
            ContactCandidates::Place& q = c.places[static_cast<std::size_t>(block) * t.lanes + lane];
            if (q.refresh != c.refresh) {
              sample_functions(m, s, block, lane, c.functions);
              q.refresh = c.refresh, q.there = !c.functions.empty() && !s.gone[c.functions[0].slot];
              if (q.there) q.x = position(s, c.functions);
            }
            if (!q.there || (q.x - centre).norm() > body.radius() + margin) continue;
            const double gap = body.distance(q.x).value;
            if (gap >= margin) continue;
            const double free = std::max(0.0, gap - 0.5 * m.thickness);
            const int first = static_cast<int>(std::min(free / travel, static_cast<double>(kContactRefresh)));
            list.push_back({block, lane, first});
          }
    }
  }
}

int contact(const ShellModel& m, ShellState& s, std::vector<Proxy>& bodies,
            const std::vector<ContactCoefficients>& coefficients, const ContactCandidates& candidates, double dt,
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
    for (const auto& candidate : candidates.of_body[b]) {
      if (candidates.age <= candidate.first) continue;
      sample_functions(m, s, candidate.block, candidate.lane, functions);  // a crack may have changed them
      if (functions.empty() || s.gone[functions[0].slot]) continue;
      const Vec3 x = position(s, functions);
      const Proxy::Distance middle = body.distance(x);
      if (middle.value > 0.5 * m.thickness) continue;
      // the face towards the body: half a thickness off the middle along the shell's own normal
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
      // The impulse acts on both sides at the mid-surface point, where the shape functions place it:
      // linear and angular momentum then close to round-off.
      const Vec3 before = velocity(s, functions) - body.velocity_at(x);
      Mat3 inverse = body.inverse_mass_at(x);
      for (const auto& f : functions) inverse.diagonal().array() += f.n[0] * f.n[0] * s.inverse_mass[f.slot];
      if (inverse.trace() <= 0.0) continue;
      // What bounces leaves the overlap by itself: a push on top would give energy, most of all to slow ones.
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

double external_power(const ShellModel& m, const ShellState& s) {
  const std::size_t plane = m.tables.plane;
  double power = 0.0;
  const std::vector<double>& moving = s.moving.empty() ? s.v : s.moving;  // loads work on what moves their points
  for (std::size_t i = 0; i < s.external.size(); ++i) power += s.external[i] * moving[i];
  for (const auto& driven : m.constraints.driven)
    for (int d = 0; d < 3; ++d)
      for (const int slot : driven.slots[d])  // what follows others over a seam has no mass, and its force is theirs
        if (s.mass[slot] > 0.0) power -= s.force[d * plane + slot] * s.v[d * plane + slot];
  return power;
}

namespace {

// Half a step's work of loads and of supports that move, at the velocities as they stand: before the kick and after
// it, together the trapezoidal rule that leapfrog's energy asks for. `inertia`: +1 adds the kinetic energy of what is
// driven along some axes and counted with the shell's, -1 takes it away: between both the support has changed it.
void book_external_work(const ShellModel& m, ShellState& s, double dt, double inertia) {
  const std::size_t plane = m.tables.plane;
  for (const auto& driven : m.constraints.driven)
    for (int d = 0; d < 3; ++d)
      for (const int slot : driven.slots[d]) {
        const double v = s.v[d * plane + slot];
        if (s.inverse_mass[slot] > 0.0) s.book.external += inertia * 0.5 * s.mass[slot] * v * v;
      }
  s.book.external += 0.5 * dt * external_power(m, s);
}

// Half a step's work that forces do on what moves otherwise than its velocity says.
void book_moving_work(ShellState& s, double dt) {
  for (std::size_t i = 0; i < s.moving.size(); ++i) s.book.transfer += 0.5 * dt * s.force[i] * (s.moving[i] - s.v[i]);
}

}  // namespace

void through_grid(const ShellModel& m, ShellState& s, const TransferRules& rules, double dt, int threads) {
  if (rules.kind == Transfer::kDirect) return;
  const std::size_t plane = m.tables.plane;
  if (!rules.leaky) constrain(m, s, dt);  // supports bear what acts on what they hold
  std::vector<double>& kicked = s.kicked;
  kicked = s.v;
  if (rules.leaky)
    for (std::size_t i = 0; i < plane; ++i)
      for (int d = 0; d < 3 && s.inverse_mass[i] == 0.0 && s.mass[i] > 0.0; ++d)
        s.v[d * plane + i] = dt * s.force[d * plane + i] / s.mass[i];
  transfer(rules.kind, rules.spacing, plane, s.mass, s.x, s.before, threads, s.transfer_buffers, s.v, s.moving,
           s.affine);
  for (std::size_t i = 0; i < plane; ++i) {
    if (s.inverse_mass[i] > 0.0) continue;
    for (int d = 0; d < 3; ++d) s.v[d * plane + i] = s.moving[d * plane + i] = 0.0;
    for (int e = 0; e < 9; ++e) s.affine[e * plane + i] = 0.0;
  }
  std::swap(s.v, s.moving);
  constrain(m, s, dt);
  std::swap(s.v, s.moving);
  constrain(m, s, dt);
  const auto lost = [&](int d, std::size_t slot) {
    const std::size_t k = d * plane + slot;
    const double back = 0.5 * dt * s.inverse_mass[slot] * s.force[k];  // to the time of the positions
    return -s.mass[slot] * (s.v[k] - kicked[k]) * (0.5 * (s.v[k] + kicked[k]) - back);
  };
  for (int d = 0; d < 3; ++d)
    for (std::size_t i = 0; i < plane; ++i)
      if (s.inverse_mass[i] > 0.0) s.book.transfer += lost(d, i);
  for (const auto& driven : m.constraints.driven)  // what supports drive, they pay for
    for (int d = 0; d < 3; ++d)
      for (const int slot : driven.slots[d])
        if (s.inverse_mass[slot] > 0.0) s.book.transfer -= lost(d, slot);
}

namespace {

// What is changed of the force on control points that supports hold, drive or tie together goes where theirs does.
std::vector<double> free_jump(const ShellModel& m, ShellState& s, double dt) {
  const std::size_t plane = m.tables.plane;
  std::vector<double> jump;
  jump.swap(s.jump);
  const Constraints& c = m.constraints;
  for (int d = 0; d < 3 && !jump.empty(); ++d) {
    double* j = &jump[d * plane];
    for (const int slot : c.held[d]) j[slot] = 0.0;
    for (const auto& group : c.tied[d]) {
      double mass = 0.0, sum = 0.0;
      for (const int slot : group)
        if (!s.gone[slot]) mass += s.mass[slot], sum += j[slot];
      for (const int slot : group) j[slot] = mass > 0.0 ? sum * s.mass[slot] / mass : 0.0;
    }
    for (const auto& driven : c.driven)
      for (const int slot : driven.slots[d]) {
        if (s.mass[slot] > 0.0) s.book.external -= 0.5 * dt * j[slot] * s.v[d * plane + slot];
        j[slot] = 0.0;
      }
    for (std::size_t slot = 0; slot < plane; ++slot)
      if (s.inverse_mass[slot] == 0.0) j[slot] = 0.0;
  }
  return jump;
}

}  // namespace

void take_up_jump(const std::vector<ShellRef>& shells, double dt) {
  if (std::all_of(shells.begin(), shells.end(), [](const ShellRef& r) { return r.state->jump.empty(); })) return;
  std::vector<std::vector<double>> jumps;
  // m v- . v+ / 2 changes by (share - 1) moving + share^2 square + share still
  double moving = 0.0, square = 0.0, still = 0.0, let_go = 0.0;
  for (const ShellRef& r : shells) {
    ShellState& s = *r.state;
    let_go += std::exchange(s.let_go, 0.0);
    const std::vector<double>& jump = jumps.emplace_back(free_jump(*r.model, *r.state, dt));
    for (std::size_t k = 0; k < jump.size(); ++k) {
      if (jump[k] == 0.0) continue;
      const std::size_t slot = k % r.model->tables.plane;
      const double mass = s.mass[slot], dv = 0.5 * dt * s.inverse_mass[slot] * jump[k];
      moving += mass * dv * s.v[k], square += 0.5 * mass * dv * dv;
      still += 0.5 * mass * dv * dt * s.inverse_mass[slot] * s.force[k];
    }
  }
  double share = 1.0;
  if (square + still > 0.0) {  // the most of it with which the energy does not rise, or where it rises least
    const double middle = -0.5 * (moving + still) / square;
    share = std::clamp(middle + std::sqrt(std::max(0.0, middle * middle + moving / square)), 0.0, 1.0);
  }
  for (std::size_t i = 0; i < shells.size(); ++i) {
    ShellState& s = *shells[i].state;
    for (std::size_t k = 0; k < jumps[i].size(); ++k)
      s.v[k] += share * 0.5 * dt * s.inverse_mass[k % shells[i].model->tables.plane] * jumps[i][k];
  }
  const double gained = (share - 1.0) * moving + share * (share * square + still);
  EnergyBook& book = shells.front().state->book;
  const double added = std::max(0.0, gained - let_go);
  book.injected += added, book.fracture += added - gained;
}

void kick(const ShellModel& m, ShellState& s, const Vec3& gravity, double step, double last) {
  if (!s.jump.empty()) take_up_jump({{&m, &s}}, last);
  const std::size_t plane = m.tables.plane;
  const double dt = 0.5 * (last + step);
  book_external_work(m, s, last, -1.0);
  book_moving_work(s, last);
  if (!s.before.empty()) s.before = s.v;
  const double alpha = m.material.mass_damping, beta = m.material.stiffness_damping;
  if (alpha > 0.0 || beta > 0.0) {
    const bool viscous = beta > 0.0 && s.last_force.size() == s.force.size();
    for (int d = 0; d < 3; ++d)
      for (std::size_t i = 0; i < plane; ++i) {
        if (s.inverse_mass[i] == 0.0) continue;
        const std::size_t k = d * plane + i;
        const double gain = viscous ? beta * (s.force[k] - s.last_force[k]) * s.inverse_mass[i] : 0.0;
        const double change = gain - dt * alpha * s.v[k];  // of v
        s.book.damping -= s.mass[i] * change * (s.v[k] + 0.5 * (dt * s.inverse_mass[i] * s.force[k] + change));
        s.v[k] += change;
      }
    if (beta > 0.0) s.last_force = s.force;
  }
  for (int d = 0; d < 3; ++d) {
    double *v = &s.v[d * plane], *f = &s.force[d * plane];
    const double g = dt * gravity[d];
    for (std::size_t i = 0; i < plane; ++i) v[i] += s.inverse_mass[i] > 0.0 ? dt * s.inverse_mass[i] * f[i] + g : 0.0;
  }
}

void constrain(const ShellModel& m, ShellState& s, double dt) {
  const Constraints& c = m.constraints;
  if (!c.partial) return;
  const std::size_t plane = m.tables.plane;
  for (int d = 0; d < 3; ++d) {
    double* v = &s.v[d * plane];
    for (const int slot : c.held[d]) v[slot] = 0.0;
    for (const auto& group : c.tied[d]) {
      double mass = 0.0, momentum = 0.0;
      for (const int slot : group) mass += s.mass[slot], momentum += s.mass[slot] * v[slot];
      if (mass > 0.0)
        for (const int slot : group)
          if (!s.gone[slot]) v[slot] = momentum / mass;
    }
    for (const auto& driven : c.driven) {
      const double u = driven.displacement(s.time + dt)[d];
      for (const int slot : driven.slots[d])
        if (!s.gone[slot]) v[slot] = (m.rest[d * plane + slot] + u - s.x[d * plane + slot]) / dt;
    }
  }
}

void drift(const ShellModel& m, ShellState& s, double dt) {
  book_external_work(m, s, dt, 1.0);
  book_moving_work(s, dt);
  s.time += dt;
  const std::vector<double>& moving = s.moving.empty() ? s.v : s.moving;
  for (std::size_t i = 0; i < s.x.size(); ++i) s.x[i] += dt * moving[i];
}

}  // namespace sunder::shell
