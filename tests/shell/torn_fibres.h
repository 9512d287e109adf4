#pragma once
// A panel whose fibres may tear too, beside its layers.
#include "shell/solver/cracking/damage_cracks.h"
#include "tests/shell/damaging_panel.h"

namespace sunder::shell {

inline FibreLaw tearing_law() { return {1e6, 1e5, 0.5, 1e4, FibreLaw{}.crushing_strength, 0.5}; }

inline ShellModel panel_with_fibres(int elements) {
  ShellModel m = panel(elements, 0.2);
  m.fibres = tearing_law();
  return m;
}

/// Puts complete damage into the fibres on one side (0: below, 1: above) where `region` says so, and lists these points
/// as a substep does.
template <class F>
void tear_fibres_where(const ShellModel& m, ShellState& s, std::size_t side, F&& region) {
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int e = 0; e < m.tables.spans_u; ++e)
      if (region(gauss_point(m.patch, m.tables, q, e).parameter)) {
        const std::size_t i = 2 * (static_cast<std::size_t>(q) * m.tables.lanes + e) + side;
        s.layers.through[i] = s.layers.through_his[i] = 1.0f;
      }
  watch_stress(m, s);
}

}  // namespace sunder::shell
