#include "shell/solver/forces.h"

#include <algorithm>
#include <atomic>
#include <functional>

#include "shell/solver/interlock.h"

namespace sunder::shell {

RowPlasticity plasticity_of(const ShellModel& m, ShellState& s) {
  RowPlasticity plastic;
  plastic.law = {m.material.yield_stress, m.material.hardening_modulus, m.material.youngs_modulus,
                 m.material.poisson_ratio};
  plastic.states = &s.layers.plastic, plastic.forms = &s.layers.plastic_forms;
  plastic.made = &s.layers.plastic_made;
  const std::atomic_ref<char> made(s.layers.plastic_made);  // threads ask for this at once; none makes states then
  if (const char now = s.layers.plastic.empty() ? 0 : 1; made.load() != now) made.store(now);
  return plastic;
}

namespace {

// Returns the least strength of each block of Gauss points [Pa].
std::vector<double> least_strengths(const ShellState& s) {
  std::vector<double> least(s.cracked.tables.blocks());
  for (int q = 0; q < s.cracked.tables.blocks(); ++q) {
    const double* first = &s.layers.strength[s.cracked.tables.at(q, 1, 0, 0)];
    least[q] = *std::min_element(first, first + s.cracked.tables.spans_u);
  }
  return least;
}

// Forces as by compute_forces(). Damage and flow advance where `advance` is true.
double forces(const ShellModel& m, ShellState& s, bool energy, double stress_share, bool advance, int threads) {
  SurfaceStress stress;
  if (stress_share > 0.0) {
    s.caches.over.resize(s.cracked.tables.blocks());
    if (s.caches.least_strength.empty()) s.caches.least_strength = least_strengths(s);
    stress = {&s.layers.face_stress, stress_share, &s.caches.least_strength, &s.caches.over};
  }
  RowPlasticity plastic;
  if (s.yields()) plastic = plasticity_of(m, s), plastic.advance = advance;
  RowDamage rows;
  if (!s.cracked.watched.empty())
    rows = {&s.cracked.watched, &s.layers.strength,   &s.cracked.point_of,
            &s.cracked.damage,  s.layers.brittleness, s.layers.heals};
  const ForceCall call{s.motion.x, energy, stress, threads};
  double sum = row_forces(s.cracked.tables, call, {&plastic, &rows, nullptr}, s.scratch.rows, s.motion.force);
  s.book.healing -= rows.healed, s.book.fracture += rows.dissipated;
  DamageLaw law{&s.cracked.damage, s.layers.brittleness, s.layers.heals};
  const auto faces = [&](int chunk, int chunks, const double* x, double* force) {
    interlock_forces(m, s, advance, chunk, chunks, x, force);
  };
  PointsBeside beside;
  if (!s.cracks.interlocks.empty()) beside = std::ref(faces);  // needs no memory
  const LayerMemory memory{&plastic, nullptr, s.weakens() ? &law : nullptr};
  sum += add_point_forces(s.cracked.tables, s.cracked.gathered, call, memory, s.scratch.points, s.motion.force, beside);
  s.book.plastic += plastic.dissipated;
  s.book.healing -= law.healed, s.book.fracture += law.dissipated;
  if (m.laminated()) {
    s.scratch.interlayer_force.resize(s.motion.force.size());
    sum += row_forces(s.cracked.interlayer, {s.motion.x, energy, {}, threads}, {}, s.scratch.rows,
                      s.scratch.interlayer_force);
    if (!s.cracked.of_interlayer.empty())
      sum += add_point_forces(s.cracked.interlayer, s.cracked.of_interlayer, {s.motion.x, energy, {}, threads}, {},
                              s.scratch.interlayer_points, s.scratch.interlayer_force);
    for (std::size_t i = 0; i < s.motion.force.size(); ++i) s.motion.force[i] += s.scratch.interlayer_force[i];
  }
  s.cracks.interlock_energy = interlock_energy(s);
  if (advance) book_faces(s);
  if (!m.loads.empty()) {
    load_forces(m.loads, s.cracked.tables, s.cracked.gathered, s.motion.time, s.motion.x, threads, s.scratch.rows,
                s.motion.external);
    for (std::size_t i = 0; i < s.motion.force.size(); ++i) s.motion.force[i] += s.motion.external[i];
  }
  return energy ? sum + s.cracks.interlock_energy : 0.0;
}

}  // namespace

double compute_forces(const ShellModel& m, ShellState& s, bool energy, double stress_share, int threads) {
  return forces(m, s, energy, stress_share, stress_share > 0.0, threads);
}

void advance_forces(const ShellModel& m, ShellState& s, double stress_share, int threads) {
  forces(m, s, false, stress_share, stress_share > 0.0 || s.yields(), threads);
}

void scale_forces(ShellState& s, double factor) {
  for (std::vector<double>* all : {&s.motion.force, &s.motion.external, &s.cracks.force_discontinuity})
    for (double& f : *all) f *= factor;
}

void clear_forces(ShellState& s) {
  std::fill(s.motion.force.begin(), s.motion.force.end(), 0.0);
  std::fill(s.motion.external.begin(), s.motion.external.end(), 0.0);
}

double kinetic_energy(const ShellModel& m, const ShellState& s, double dt) {
  const std::size_t stride = m.tables.component_stride;
  double sum = 0.0;
  for (int d = 0; d < 3; ++d)
    for (std::size_t i = 0; i < stride; ++i) {
      if (s.motion.inverse_mass[i] == 0.0) continue;
      const double v = s.motion.v[d * stride + i];
      sum += 0.5 * s.motion.mass[i] * v * (v + dt * s.motion.inverse_mass[i] * s.motion.force[d * stride + i]);
    }
  for (const auto& driven : m.constraints.driven)  // forces do not move a driven control point
    for (int d = 0; d < 3; ++d)
      for (const int slot : driven.slots[d])
        if (s.motion.inverse_mass[slot] > 0.0 && s.motion.mass[slot] > 0.0)
          sum -= 0.5 * dt * s.motion.v[d * stride + slot] * s.motion.force[d * stride + slot];
  return sum;
}

double potential_energy(const ShellModel& m, const ShellState& s, const Vec3& gravity) {
  double sum = 0.0;
  for (int i = 0; i < m.tables.component_stride; ++i)
    if (s.motion.inverse_mass[i] > 0.0) sum -= s.motion.mass[i] * gravity.dot(s.position(i));
  return sum;
}

}  // namespace sunder::shell
