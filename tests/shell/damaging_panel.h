#pragma once
// A square panel whose cracks damage drives.
#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "shell/solver/forces.h"
#include "tests/shell/fixtures.h"

namespace sunder::shell {

constexpr double kYoung = 3e9, kStrength = 2e6, kToughness = 12.0;

inline ShellModel panel(const std::string& name, const Patch& patch, double poisson) {
  ShellMaterial m;
  m.density = 1000, m.youngs_modulus = kYoung, m.poisson_ratio = poisson;
  m.strength = kStrength, m.fracture_energy = kToughness;
  return make_shell(name, patch, 0.01, m, 2, 2, {});
}
inline ShellModel panel(int elements, double poisson) {
  return panel("p", plate(0.3, 0.3, elements, elements, Vec3::Zero(), Quat::Identity()), poisson);
}

inline double width(const ShellModel& m) { return std::sqrt(3.0) * m.spacing; }

inline ShellState damaging(const ShellModel& m) {
  ShellState s = make_state(m, Vec3::Zero(), 1);
  s.layers.brittleness = brittleness(kStrength, kYoung, kToughness, width(m));
  EXPECT_GT(s.layers.brittleness, 0.0);
  return s;
}

inline void stretch_x(const ShellModel& m, ShellState& s, double strain) {
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    s.motion.x[slot] = m.rest[slot] * std::sqrt(1.0 + 2.0 * strain);  // Green's strain
  }
}

// Puts complete damage where `region` says so, as the law would have found it.
template <class F>
void damage_where(const ShellModel& m, ShellState& s, F&& region) {
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int e = 0; e < m.tables.spans_u; ++e)
      if (region(gauss_point(m.patch, m.tables, q, e).parameter)) {
        const int point = gather_point(m, s, q, e);
        for (auto* layers : {&s.cracked.damage[point].now, &s.cracked.damage[point].history}) (*layers)[0] = 1.0f;
      }
}

// Folds the panel about a line along y in its middle: it turns by `curvature` [1/m] over `band` [m].
inline void fold(const ShellModel& m, ShellState& s, double curvature, double band) {
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    const double x = m.rest[slot], from = -0.5 * band, within = std::clamp(x - from, 0.0, band);
    const double angle = curvature * within, after = std::max(0.0, x - from - band);
    s.motion.x[slot] = std::min(x, from) + std::sin(angle) / curvature + std::cos(angle) * after;
    s.motion.x[2 * m.tables.component_stride + slot] = (1.0 - std::cos(angle)) / curvature + std::sin(angle) * after;
  }
}

// Folded about a radius of two thirds of its thickness, and spent there.
inline ShellState spent_fold(const ShellModel& m) {
  ShellState s = damaging(m);
  fold(m, s, 150.0, 0.015);
  damage_where(m, s, [](const Vec2& p) { return std::abs(p.x() - 0.15) < 0.02; });
  compute_forces(m, s, false, 1.0, 1);
  return s;
}

}  // namespace sunder::shell
