#include "shell/solver/state.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "coupler/core/error.h"

namespace sunder::shell {
namespace {

// Strength is the material's, times the scene's factors, times a Weibull factor. The Weibull factor is constant in
// cells of the flaw spacing. The seed turns and shifts the lattice of cells, so that it shares no direction with the
// patch.
void assign_strength(const ShellModel& m, ShellState& s, std::uint64_t seed) {
  const RowTables& t = m.tables;
  s.layers.strength.assign(static_cast<std::size_t>(t.blocks()) * t.lanes, m.material.strength);
  for (std::size_t g = 0; g < m.strength_factor.size(); ++g) s.layers.strength[g] *= m.strength_factor[g];
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
      std::uint64_t h = salt;  // splitmix hash of the cell's coordinates
      for (const double cell : {std::floor(a), std::floor(b)}) {
        h += static_cast<std::uint64_t>(static_cast<std::int64_t>(cell)) + 0x9e3779b97f4a7c15ULL;
        h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
        h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
        h ^= h >> 31;
      }
      double& strength = s.layers.strength[static_cast<std::size_t>(q) * t.lanes + e];
      strength = strength * std::pow(-std::log(uniform(h)), 1.0 / w) / mean;
    }
}

}  // namespace

ShellState make_state(const ShellModel& m, const Vec3& velocity, std::uint64_t seed) {
  const RowTables& t = m.tables;
  ShellState s;
  const std::size_t stride = t.component_stride, gauss = static_cast<std::size_t>(t.blocks()) * t.lanes;
  s.motion.x.assign(3 * stride, 0.0), s.motion.v.assign(3 * stride, 0.0), s.motion.force.assign(3 * stride, 0.0);
  s.motion.mass = m.mass;
  s.motion.inverse_mass.assign(stride, 0.0);
  s.motion.detached.assign(stride, 0);
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = t.slot(i);
    for (int d = 0; d < 3; ++d) s.motion.x[d * stride + slot] = m.patch.control_points[i][d];
    if (m.held[slot] || m.trim.drops(slot)) continue;
    s.motion.inverse_mass[slot] = 1.0 / m.mass[slot];
    for (int d = 0; d < 3; ++d) s.motion.v[d * stride + slot] = velocity[d];
  }
  for (int d = 0; d < 3; ++d)  // a held point has neither this velocity nor its energy
    for (const int slot : m.constraints.held[d]) s.motion.v[d * stride + slot] = 0.0;
  s.layers.face_stress.assign(gauss * 6, 0.0);
  s.layers.c.assign(gauss, 0.0f), s.layers.c_his.assign(gauss, 0.0f);
  if (m.material.yield_stress > 0.0) {
    s.layers.plastic_forms.resize(gauss * kFormFields);
    for (int q = 0; q < t.blocks(); ++q)  // the metric begins with the forms at rest, in the same order
      std::copy_n(&t.metric[t.at(q, kMetricFields, kA11, 0)], kFormFields * t.lanes,
                  &s.layers.plastic_forms[t.at(q, kFormFields, 0, 0)]);
  }
  if (m.has_fibres()) {
    s.layers.fibres.assign(gauss * 6, 0.0);
    for (std::size_t i = 2; i < s.layers.fibres.size(); i += 3) s.layers.fibres[i] = 1.0;
    if (m.fibres.breaks()) s.layers.through.assign(gauss * 2, 0.0f), s.layers.through_his.assign(gauss * 2, 0.0f);
  }
  s.cracked.kind_of.assign(gauss, static_cast<char>(PointKind::kQuadratic));
  s.cracked.point_of.assign(gauss, -1), s.caches.visibility_of.assign(gauss, -1), s.cracked.reach.assign(gauss, 0.0f);
  s.cracked.tables = t, s.cracked.interlayer = m.interlayer;
  s.cracks.graph =
      CrackGraph({m.patch.knots_u.begin(), m.patch.knots_v.begin()}, {m.patch.knots_u.end(), m.patch.knots_v.end()},
                 2.0 * m.spacing, kLengthening * m.spacing);
  if (!m.trim.empty()) trim_state(m, s);
  assign_strength(m, s, seed);
  return s;
}

void sample_functions(const ShellModel& m, const ShellState& s, int block, int lane,
                      std::vector<GatheredFunction>& out) {
  out.clear();
  const RowTables& t = m.tables;
  const int point = s.cracked.point_of[static_cast<std::size_t>(block) * t.lanes + lane];
  if (point >= 0) {
    if (s.cracked.gathered[point].kind != PointKind::kDead) out = s.cracked.gathered[point].functions;
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
