#include "shell/solver/stepping/kick_drift.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sunder::shell {

double external_power(const ShellModel& m, const ShellState& s) {
  const std::size_t stride = m.tables.component_stride;
  double power = 0.0;
  const std::vector<double>& moving =
      s.motion.moving.empty() ? s.motion.v : s.motion.moving;  // loads work on what moves their points
  for (std::size_t i = 0; i < s.motion.external.size(); ++i) power += s.motion.external[i] * moving[i];
  for (const auto& driven : m.constraints.driven)
    for (int d = 0; d < 3; ++d)
      // a dependent control point has no mass; its force counts at those it depends on
      for (const int slot : driven.slots[d])
        if (s.motion.mass[slot] > 0.0) power -= s.motion.force[d * stride + slot] * s.motion.v[d * stride + slot];
  return power;
}

namespace {

// Books half a step's work of loads and moving supports at the present velocities. The halves before and after the kick
// make the trapezoidal rule that fits leapfrog's energy. A point that is driven along some axes counts in the shell's
// kinetic energy: `inertia` +1 adds that energy, -1 subtracts it. The difference is the support's work.
void book_external_work(const ShellModel& m, ShellState& s, double dt, double inertia) {
  const std::size_t stride = m.tables.component_stride;
  for (const auto& driven : m.constraints.driven)
    for (int d = 0; d < 3; ++d)
      for (const int slot : driven.slots[d]) {
        const double v = s.motion.v[d * stride + slot];
        if (s.motion.inverse_mass[slot] > 0.0) s.book.external += inertia * 0.5 * s.motion.mass[slot] * v * v;
      }
  s.book.external += 0.5 * dt * external_power(m, s);
}

// Books half a step's work of forces on points that move with other velocities than those stored.
void book_moving_work(ShellState& s, double dt) {
  for (std::size_t i = 0; i < s.motion.moving.size(); ++i)
    s.book.transfer += 0.5 * dt * s.motion.force[i] * (s.motion.moving[i] - s.motion.v[i]);
}

}  // namespace

namespace {

// Books what supports bear in a kick: forces and weight of control points that are held along all axes. Those that are
// held along some axes are kicked, and constrain() takes their velocity back.
void book_support_impulse(const ShellModel& m, ShellState& s, const Vec3& gravity, double dt) {
  std::vector<double>& sum = s.motion.support_impulse;
  if (sum.empty()) return;
  const std::size_t stride = m.tables.component_stride;
  const double beta = s.motion.last_force.size() == s.motion.force.size() ? m.material.stiffness_damping : 0.0;
  for (std::size_t i = 0; i < stride; ++i) {
    // A dependent control point at a seam has no mass; its force counts at those it depends on.
    if (!m.held[i] || s.motion.inverse_mass[i] > 0.0 || !(s.motion.mass[i] > 0.0)) continue;
    for (int d = 0; d < 3; ++d) {
      const std::size_t k = d * stride + i;
      sum[k] -= dt * (s.motion.force[k] + s.motion.mass[i] * gravity[d]);
      if (beta > 0.0) sum[k] -= beta * (s.motion.force[k] - s.motion.last_force[k]);
    }
  }
}

// Takes the force discontinuity out of the state. Supports act on it as on forces: it is zero at held and driven
// control points, and shared by mass in tied groups.
std::vector<double> free_discontinuity(const ShellModel& m, ShellState& s, double dt) {
  const std::size_t stride = m.tables.component_stride;
  std::vector<double> discontinuity;
  discontinuity.swap(s.cracks.force_discontinuity);
  const Constraints& c = m.constraints;
  for (int d = 0; d < 3 && !discontinuity.empty(); ++d) {
    double* j = &discontinuity[d * stride];
    for (const int slot : c.held[d]) j[slot] = 0.0;
    for (const auto& group : c.tied[d]) {
      double mass = 0.0, sum = 0.0;
      for (const int slot : group)
        if (!s.motion.detached[slot]) mass += s.motion.mass[slot], sum += j[slot];
      for (const int slot : group) j[slot] = mass > 0.0 ? sum * s.motion.mass[slot] / mass : 0.0;
    }
    for (const auto& driven : c.driven)
      for (const int slot : driven.slots[d]) {
        if (s.motion.mass[slot] > 0.0) s.book.external -= 0.5 * dt * j[slot] * s.motion.v[d * stride + slot];
        j[slot] = 0.0;
      }
    for (std::size_t slot = 0; slot < stride; ++slot)
      if (s.motion.inverse_mass[slot] == 0.0) j[slot] = 0.0;
  }
  return discontinuity;
}

// A force discontinuity as a change of velocities, and the share of it that is applied to the half kick before. It
// changes the energy m v- . v+ / 2 by (share - 1) moving + share^2 square + share still.
struct KickChange {
  double moving = 0.0, square = 0.0, still = 0.0, share = 1.0;  // [J], [J], [J], [-]

  double gain() const { return (share - 1.0) * moving + share * (share * square + still); }
  // The largest share without a gain, or the one with the least gain.
  void without_gain() {
    if (!(square + still > 0.0)) return;
    const double middle = -0.5 * (moving + still) / square;
    share = std::clamp(middle + std::sqrt(std::max(0.0, middle * middle + moving / square)), 0.0, 1.0);
  }
  // The share, mostly negative, with which the energy rises by `surplus` [J] as faces move apart, at least `least`.
  void with_gain(double surplus, double least) {
    if (!(square > 0.0)) return;
    const double middle = -0.5 * (moving + still) / square;
    share = middle - std::sqrt(std::max(0.0, middle * middle + (moving + surplus) / square));
    share = std::max(share, least);
  }
};

// Damping of one kick.
struct Damping {
  ShellState& s;
  double dt, alpha, beta;  // [s], [1/s], [s]; no `beta` before there are two forces

  // Change of the velocity of component k, of control point i [m/s].
  double change(std::size_t k, std::size_t i) const {
    const double gain =
        beta > 0.0 ? beta * (s.motion.force[k] - s.motion.last_force[k]) * s.motion.inverse_mass[i] : 0.0;
    return gain - dt * alpha * s.motion.v[k];
  }
  // Acceleration by forces alone. What seams join moves by the inverse of their common mass.
  double acceleration(std::size_t k, std::size_t i) const { return s.motion.inverse_mass[i] * s.motion.force[k]; }
  // Energy m v- . v+ / 2 that a change of velocity takes from a mass, as forces accelerate it [J].
  double taken(double mass, double velocity, double acceleration, double change) const {
    return -mass * change * (velocity + 0.5 * (dt * acceleration + change));
  }
  double taken(std::size_t k, std::size_t i) const {
    if (s.motion.inverse_mass[i] == 0.0) return 0.0;
    return taken(s.motion.mass[i], s.motion.v[k], acceleration(k, i), change(k, i));
  }
  // Of points that a support ties together: they have one velocity.
  double taken_together(std::size_t first, const std::vector<int>& slots) const {
    double mass = 0.0, force = 0.0, change_of = 0.0, velocity = 0.0;  // sums over masses
    for (const int slot : slots) {
      if (s.motion.inverse_mass[slot] == 0.0) continue;
      const double own = s.motion.mass[slot];
      mass += own, force += own * acceleration(first + slot, slot), change_of += own * change(first + slot, slot);
      velocity += own * s.motion.v[first + slot];
    }
    return mass > 0.0 ? taken(mass, velocity / mass, force / mass, change_of / mass) : 0.0;
  }

  void book(const ShellModel& m) const {
    const std::size_t stride = m.tables.component_stride;
    const Constraints& c = m.constraints;
    double sum = 0.0;
    for (int d = 0; d < 3; ++d) {
      const std::size_t first = d * stride;
      for (std::size_t i = 0; i < stride; ++i) sum += taken(first + i, i);
      for (const int slot : c.held[d]) sum -= taken(first + slot, slot);  // it does not move
      for (const auto& group : c.tied[d]) {
        for (const int slot : group) sum -= taken(first + slot, slot);
        sum += taken_together(first, group);
      }
      for (const auto& driven : c.driven)  // the support replaces what damping takes
        for (const int slot : driven.slots[d]) s.book.external += taken(first + slot, slot);
    }
    s.book.damping += sum;
  }
};

}  // namespace

void apply_force_discontinuity(const std::vector<ShellRef>& shells, double dt) {
  if (std::all_of(shells.begin(), shells.end(),
                  [](const ShellRef& r) { return r.state->cracks.force_discontinuity.empty(); }))
    return;
  std::vector<std::vector<double>> discontinuities, whole;  // free parts; with what supports bear
  KickChange change;
  double released_energy = 0.0, by_faces = 0.0, surplus = 0.0, passage = 0.0;
  for (const ShellRef& r : shells) {
    ShellState& s = *r.state;
    released_energy += std::exchange(s.cracks.released, 0.0);
    by_faces += std::exchange(s.cracks.released_by_faces, 0.0);
    if (s.cracks.surplus > 0.0) surplus += s.cracks.surplus, passage = std::max(passage, r.model->response_time());
    whole.push_back(s.motion.support_impulse.empty() ? std::vector<double>{} : s.cracks.force_discontinuity);
    const std::vector<double>& discontinuity = discontinuities.emplace_back(free_discontinuity(*r.model, *r.state, dt));
    for (std::size_t k = 0; k < discontinuity.size(); ++k) {
      if (discontinuity[k] == 0.0) continue;
      const std::size_t slot = k % r.model->tables.component_stride;
      const double mass = s.motion.mass[slot], dv = 0.5 * dt * s.motion.inverse_mass[slot] * discontinuity[k];
      change.moving += mass * dv * s.motion.v[k], change.square += 0.5 * mass * dv * dv;
      change.still += 0.5 * mass * dv * dt * s.motion.inverse_mass[slot] * s.motion.force[k];
    }
  }
  if (surplus > 0.0)
    change.with_gain(surplus, -passage / (0.5 * dt));
  else
    change.without_gain();
  for (std::size_t i = 0; i < shells.size(); ++i) {
    ShellState& s = *shells[i].state;
    for (std::size_t k = 0; k < discontinuities[i].size(); ++k)
      s.motion.v[k] += change.share * 0.5 * dt * s.motion.inverse_mass[k % shells[i].model->tables.component_stride] *
                       discontinuities[i][k];
    for (std::size_t k = 0; k < whole[i].size(); ++k)
      s.motion.support_impulse[k] -= change.share * 0.5 * dt * (whole[i][k] - discontinuities[i][k]);
  }
  const double returned = std::clamp(change.gain(), 0.0, surplus), gained = change.gain() - returned;
  for (const ShellRef& r : shells) {
    Cracks& c = r.state->cracks;
    const double share = surplus > 0.0 ? std::exchange(c.surplus, 0.0) / surplus : 0.0;
    c.taken -= share * returned, r.state->book.fracture -= share * returned;
  }
  EnergyBook& book = shells.front().state->book;
  released_energy -= returned;
  const double added = std::max(0.0, gained - released_energy);
  // a gain is charged to what released it, in the shares of their energies
  const double of_faces = gained > 0.0 && released_energy > 0.0 ? (gained - added) * by_faces / released_energy : 0.0;
  book.injected += added, book.fracture += added - gained + of_faces, book.face_friction -= of_faces;
}

void kick(const ShellModel& m, ShellState& s, const Vec3& gravity, double step, double last) {
  if (!s.cracks.force_discontinuity.empty()) apply_force_discontinuity({{&m, &s}}, last);
  const std::size_t stride = m.tables.component_stride;
  const double dt = 0.5 * (last + step);
  book_external_work(m, s, last, -1.0);
  book_moving_work(s, last);
  if (!s.motion.before.empty()) s.motion.before = s.motion.v;
  book_support_impulse(m, s, gravity, dt);
  const double alpha = m.material.mass_damping, beta = m.material.stiffness_damping;
  if (alpha > 0.0 || beta > 0.0) {
    const Damping damping{s, dt, alpha, s.motion.last_force.size() == s.motion.force.size() ? beta : 0.0};
    damping.book(m);
    for (int d = 0; d < 3; ++d)
      for (std::size_t i = 0; i < stride; ++i)
        if (s.motion.inverse_mass[i] > 0.0) s.motion.v[d * stride + i] += damping.change(d * stride + i, i);
    if (beta > 0.0) s.motion.last_force = s.motion.force;
  }
  for (int d = 0; d < 3; ++d) {
    double *v = &s.motion.v[d * stride], *f = &s.motion.force[d * stride];
    const double g = dt * gravity[d];
    for (std::size_t i = 0; i < stride; ++i)
      v[i] += s.motion.inverse_mass[i] > 0.0 ? dt * s.motion.inverse_mass[i] * f[i] + g : 0.0;
  }
}

void constrain(const ShellModel& m, ShellState& s, double dt) {
  const Constraints& c = m.constraints;
  if (!c.partial) return;
  const std::size_t stride = m.tables.component_stride;
  std::vector<double>& borne = s.motion.support_impulse;
  for (int d = 0; d < 3; ++d) {
    double* v = &s.motion.v[d * stride];
    if (!borne.empty())
      for (const int slot : c.held[d]) borne[d * stride + slot] -= s.motion.mass[slot] * v[slot];
    for (const int slot : c.held[d]) v[slot] = 0.0;
    for (const auto& group : c.tied[d]) {
      double mass = 0.0, momentum = 0.0;
      for (const int slot : group) mass += s.motion.mass[slot], momentum += s.motion.mass[slot] * v[slot];
      if (mass > 0.0)
        for (const int slot : group)
          if (!s.motion.detached[slot]) v[slot] = momentum / mass;
    }
    for (const auto& driven : c.driven) {
      const double u = driven.displacement(s.motion.time + dt)[d];
      for (const int slot : driven.slots[d])
        if (!s.motion.detached[slot]) {
          const double before = v[slot];
          v[slot] = (m.rest[d * stride + slot] + u - s.motion.x[d * stride + slot]) / dt;
          if (!borne.empty()) borne[d * stride + slot] += s.motion.mass[slot] * (v[slot] - before);
        }
    }
  }
}

void drift(const ShellModel& m, ShellState& s, double dt) {
  book_external_work(m, s, dt, 1.0);
  book_moving_work(s, dt);
  s.motion.time += dt;
  const std::vector<double>& moving = s.motion.moving.empty() ? s.motion.v : s.motion.moving;
  for (std::size_t i = 0; i < s.motion.x.size(); ++i) s.motion.x[i] += dt * moving[i];
}

}  // namespace sunder::shell
