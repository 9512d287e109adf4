#include "shell/solver/stepping/grid_transfer.h"

#include <utility>

#include "shell/solver/stepping/kick_drift.h"

namespace sunder::shell {

void through_grid(const ShellModel& m, ShellState& s, const TransferRules& rules, double dt, int threads) {
  if (rules.kind == Transfer::kDirect) return;
  const std::size_t plane = m.tables.plane;
  if (!rules.leaky) constrain(m, s, dt);  // supports bear forces on held control points
  std::vector<double>& kicked = s.motion.kicked;
  kicked = s.motion.v;
  if (rules.leaky)
    for (std::size_t i = 0; i < plane; ++i)
      for (int d = 0; d < 3 && s.motion.inverse_mass[i] == 0.0 && s.motion.mass[i] > 0.0; ++d)
        s.motion.v[d * plane + i] = dt * s.motion.force[d * plane + i] / s.motion.mass[i];
  transfer(rules.kind, rules.spacing, plane, s.motion.mass, s.motion.x, s.motion.before, threads, s.scratch.transfer,
           s.motion.v, s.motion.moving, s.motion.affine);
  for (std::size_t i = 0; i < plane; ++i) {
    if (s.motion.inverse_mass[i] > 0.0) continue;
    for (int d = 0; d < 3; ++d) s.motion.v[d * plane + i] = s.motion.moving[d * plane + i] = 0.0;
    for (int e = 0; e < 9; ++e) s.motion.affine[e * plane + i] = 0.0;
  }
  std::swap(s.motion.v, s.motion.moving);
  constrain(m, s, dt);
  std::swap(s.motion.v, s.motion.moving);
  constrain(m, s, dt);
  const auto lost = [&](int d, std::size_t slot) {
    const std::size_t k = d * plane + slot;
    const double back = 0.5 * dt * s.motion.inverse_mass[slot] * s.motion.force[k];  // to the time of the positions
    return -s.motion.mass[slot] * (s.motion.v[k] - kicked[k]) * (0.5 * (s.motion.v[k] + kicked[k]) - back);
  };
  for (int d = 0; d < 3; ++d)
    for (std::size_t i = 0; i < plane; ++i)
      if (s.motion.inverse_mass[i] > 0.0) s.book.transfer += lost(d, i);
  for (const auto& driven : m.constraints.driven)  // the energy of driven control points is booked at their support
    for (int d = 0; d < 3; ++d)
      for (const int slot : driven.slots[d])
        if (s.motion.inverse_mass[slot] > 0.0) s.book.transfer -= lost(d, slot);
}

}  // namespace sunder::shell
