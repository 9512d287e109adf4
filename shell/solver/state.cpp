#include "shell/solver/state.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "coupler/core/error.h"
#include "shell/solver/interlock.h"

namespace sunder::shell {
namespace {

constexpr double kLengthening = 1e-2;  // of the spacing: crack edges block sight this far past their ends

// The material's strength times the scene's factors, and Weibull's on a lattice of cells of the flaw spacing, turned
// and shifted by the seed so that it shares no direction with the patch.
void assign_strength(const ShellModel& m, ShellState& s, std::uint64_t seed) {
  const RowTables& t = m.tables;
  s.strength.assign(static_cast<std::size_t>(t.blocks()) * t.lanes, m.material.strength);
  for (std::size_t g = 0; g < m.strength_factor.size(); ++g) s.strength[g] *= m.strength_factor[g];
  const double w = m.material.weibull_modulus;
  if (w <= 0.0) return;
  std::mt19937_64 random(seed * 7919 + 1);
  const auto uniform = [](std::uint64_t bits) { return (static_cast<double>(bits >> 11) + 0.5) * 0x1.0p-53; };
  const double angle = uniform(random()) * 3.14159265358979, shift_u = uniform(random()), shift_v = uniform(random());
  const std::uint64_t salt = random();
  const double mean = std::tgamma(1.0 + 1.0 / w);
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e) {
      const Vec2 p = gauss_point(m.patch, t, q, e).parameter;
      const double a = (std::cos(angle) * p.x() - std::sin(angle) * p.y()) / m.material.flaw_spacing + shift_u;
      const double b = (std::sin(angle) * p.x() + std::cos(angle) * p.y()) / m.material.flaw_spacing + shift_v;
      std::uint64_t h = salt;  // splitmix over the cell's coordinates
      for (const double cell : {std::floor(a), std::floor(b)}) {
        h += static_cast<std::uint64_t>(static_cast<std::int64_t>(cell)) + 0x9e3779b97f4a7c15ULL;
        h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
        h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
        h ^= h >> 31;
      }
      double& strength = s.strength[static_cast<std::size_t>(q) * t.lanes + e];
      strength = strength * std::pow(-std::log(uniform(h)), 1.0 / w) / mean;
    }
}

}  // namespace

ShellState make_state(const ShellModel& m, const Vec3& velocity, std::uint64_t seed) {
  const RowTables& t = m.tables;
  ShellState s;
  const std::size_t plane = t.plane, gauss = static_cast<std::size_t>(t.blocks()) * t.lanes;
  s.x.assign(3 * plane, 0.0), s.v.assign(3 * plane, 0.0), s.force.assign(3 * plane, 0.0);
  s.mass = m.mass;
  s.inverse_mass.assign(plane, 0.0);
  s.gone.assign(plane, 0);
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = t.slot(i);
    for (int d = 0; d < 3; ++d) s.x[d * plane + slot] = m.patch.control_points[i][d];
    if (m.held[slot]) continue;
    s.inverse_mass[slot] = 1.0 / m.mass[slot];
    for (int d = 0; d < 3; ++d) s.v[d * plane + slot] = velocity[d];
  }
  for (int d = 0; d < 3; ++d)  // what a support holds never had that velocity, nor its energy
    for (const int slot : m.constraints.held[d]) s.v[d * plane + slot] = 0.0;
  s.surface_stress.assign(gauss * 6, 0.0);
  s.c.assign(gauss, 0.0f), s.c_his.assign(gauss, 0.0f);
  if (m.material.yield_stress > 0.0) {
    s.plastic.assign(gauss * 4 * t.layers.zeta.size(), 0.0);
    s.plastic_forms.resize(gauss * kFormFields);
    for (int q = 0; q < t.blocks(); ++q)  // the metric's first fields are the forms at rest, in the same order
      std::copy_n(&t.metric[t.at(q, kMetricFields, kA11, 0)], kFormFields * t.lanes,
                  &s.plastic_forms[t.at(q, kFormFields, 0, 0)]);
  }
  if (m.has_fibres()) {
    s.fibres.assign(gauss * 6, 0.0);
    for (std::size_t i = 2; i < s.fibres.size(); i += 3) s.fibres[i] = 1.0;
  }
  s.kind_of.assign(gauss, static_cast<char>(PointKind::kQuadratic));
  s.point_of.assign(gauss, -1), s.sight_of.assign(gauss, -1), s.reach.assign(gauss, 0.0f);
  s.tables = t, s.interlayer = m.interlayer;
  s.cracks = CrackGraph({m.patch.knots_u.begin(), m.patch.knots_v.begin()},
                        {m.patch.knots_u.end(), m.patch.knots_v.end()}, 2.0 * m.spacing, kLengthening * m.spacing);
  assign_strength(m, s, seed);
  return s;
}

RowPlasticity plasticity_of(const ShellModel& m, ShellState& s) {
  RowPlasticity plastic;
  plastic.law = {m.material.yield_stress, m.material.hardening_modulus, m.material.youngs_modulus,
                 m.material.poisson_ratio};
  plastic.states = &s.plastic, plastic.forms = &s.plastic_forms;
  return plastic;
}

// Of each block of Gauss points.
std::vector<double> least_strengths(const ShellState& s) {
  std::vector<double> least(s.tables.blocks());
  for (int q = 0; q < s.tables.blocks(); ++q) {
    const double* first = &s.strength[s.tables.at(q, 1, 0, 0)];
    least[q] = *std::min_element(first, first + s.tables.spans_u);
  }
  return least;
}

double compute_forces(const ShellModel& m, ShellState& s, bool energy, double stress_share, int threads) {
  SurfaceStress stress;
  if (stress_share > 0.0) {
    s.over.resize(s.tables.blocks());
    if (s.least_strength.empty()) s.least_strength = least_strengths(s);
    stress = {&s.surface_stress, stress_share, &s.least_strength, &s.over};
  }
  RowPlasticity plastic;
  if (s.yields()) plastic = plasticity_of(m, s), plastic.advance = stress_share > 0.0;
  RowDamage rows;
  if (!s.watched.empty()) rows = {&s.watched, &s.strength, &s.point_of, &s.damage, s.brittleness, s.heals};
  double sum = row_forces(s.tables, s.x, energy, stress, threads, s.row_scratch, s.force, &plastic, &rows);
  s.book.healing -= rows.healed, s.book.fracture += rows.dissipated;
  DamageLaw law{&s.damage, s.brittleness, s.heals};
  const auto faces = [&](int chunk, int chunks, const double* x4, double* force4) {
    interlock_forces(m, s, stress_share > 0.0, chunk, chunks, x4, force4);
  };
  PointsBeside beside;
  if (!s.interlocks.empty()) beside = std::ref(faces);  // which needs no memory
  sum += add_point_forces(s.tables, s.points, s.x, energy, stress, threads, s.point_scratch, s.force,
                          s.brittleness > 0.0 ? &law : nullptr, s.yields() ? &plastic : nullptr, beside);
  s.book.plastic += plastic.dissipated;
  s.book.healing -= law.healed, s.book.fracture += law.dissipated;
  if (m.laminated()) {
    s.interlayer_force.resize(s.force.size());
    sum += row_forces(s.interlayer, s.x, energy, {}, threads, s.row_scratch, s.interlayer_force);
    for (std::size_t i = 0; i < s.force.size(); ++i) s.force[i] += s.interlayer_force[i];
  }
  s.interlock_energy = interlock_energy(s);
  if (!m.loads.empty()) {
    load_forces(m.loads, s.tables, s.points, s.time, s.x, threads, s.row_scratch, s.external);
    for (std::size_t i = 0; i < s.force.size(); ++i) s.force[i] += s.external[i];
  }
  return energy ? sum + s.interlock_energy : 0.0;
}

double kinetic_energy(const ShellModel& m, const ShellState& s, double dt) {
  const std::size_t plane = m.tables.plane;
  double sum = 0.0;
  for (int d = 0; d < 3; ++d)
    for (std::size_t i = 0; i < plane; ++i) {
      if (s.inverse_mass[i] == 0.0) continue;
      const double v = s.v[d * plane + i];
      sum += 0.5 * s.mass[i] * v * (v + dt * s.inverse_mass[i] * s.force[d * plane + i]);
    }
  for (const auto& driven : m.constraints.driven)  // forces do not move what a support drives
    for (int d = 0; d < 3; ++d)
      for (const int slot : driven.slots[d])
        if (s.inverse_mass[slot] > 0.0 && s.mass[slot] > 0.0)
          sum -= 0.5 * dt * s.v[d * plane + slot] * s.force[d * plane + slot];
  return sum;
}

double potential_energy(const ShellModel& m, const ShellState& s, const Vec3& gravity) {
  double sum = 0.0;
  for (int i = 0; i < m.tables.plane; ++i)
    if (s.inverse_mass[i] > 0.0) sum -= s.mass[i] * gravity.dot(s.position(i));
  return sum;
}

void sample_functions(const ShellModel& m, const ShellState& s, int block, int lane,
                      std::vector<GatheredFunction>& out) {
  out.clear();
  const RowTables& t = m.tables;
  const int point = s.point_of[static_cast<std::size_t>(block) * t.lanes + lane];
  if (point >= 0) {
    if (s.points[point].kind != PointKind::kDead) out = s.points[point].functions;
    return;
  }
  const int row = block / t.gauss, a = block % t.gauss, f = row / t.gauss;
  const double inverse = t.rational ? t.denominator[t.at(block, kRationalFields, kInvW, lane)] : 1.0;
  const int support = t.support();
  for (int j = 0; j < support; ++j)
    for (int i = 0; i < support; ++i) {
      const int slot = (f + j) * t.stride + lane + i;
      const double value = t.basis_u[(a * 3 * support + i) * t.lanes + lane] *
                           t.basis_v[static_cast<std::size_t>(row) * 3 * support + j];
      out.push_back({slot, {t.rational ? value * t.weight[slot] * inverse : value, 0, 0, 0, 0, 0}});
    }
}

}  // namespace sunder::shell
