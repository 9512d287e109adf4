#pragma once
// A square panel whose cracks damage drives.
#include <cmath>
#include <string>

#include <gtest/gtest.h>

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

}  // namespace sunder::shell
