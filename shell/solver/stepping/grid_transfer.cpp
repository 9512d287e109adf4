#include "shell/solver/stepping/grid_transfer.h"

#include <utility>

#include "shell/solver/stepping/kick_drift.h"

namespace sunder::shell {
namespace {

// Books the momentum of held control points as given (`sign` 1) or taken (-1) by their supports.
void book_held(const ShellModel& m, ShellState& s, double sign) {
  std::vector<double>& sum = s.motion.support_impulse;
  if (sum.empty()) return;
  const std::size_t stride = m.tables.component_stride;
  for (std::size_t i = 0; i < stride; ++i)
    for (int d = 0; d < 3 && m.held[i] && s.motion.inverse_mass[i] == 0.0; ++d)
      sum[d * stride + i] += sign * s.motion.mass[i] * s.motion.v[d * stride + i];
}

}  // namespace

void through_grid(const ShellModel& m, ShellState& s, const TransferRules& rules, double dt, int threads) {
  if (rules.kind == Transfer::kDirect) return;
  const std::size_t stride = m.tables.component_stride;
  if (!rules.leaky) constrain(m, s, dt);  // supports bear forces on held control points
  std::vector<double>& kicked = s.motion.kicked;
  kicked = s.motion.v;
  if (rules.leaky)
    for (std::size_t i = 0; i < stride; ++i)
      for (int d = 0; d < 3 && s.motion.inverse_mass[i] == 0.0 && s.motion.mass[i] > 0.0; ++d)
        s.motion.v[d * stride + i] = dt * s.motion.force[d * stride + i] / s.motion.mass[i];
  book_held(m, s, 1.0);
  transfer(rules.kind, rules.spacing, stride, s.motion.mass, s.motion.x, s.motion.before, threads, s.scratch.transfer,
           s.motion.v, s.motion.moving, s.motion.affine);
  book_held(m, s, -1.0);
  for (std::size_t i = 0; i < stride; ++i) {
    if (s.motion.inverse_mass[i] > 0.0) continue;
    for (int d = 0; d < 3; ++d) s.motion.v[d * stride + i] = s.motion.moving[d * stride + i] = 0.0;
    for (int e = 0; e < 9 && !s.motion.affine.empty(); ++e) s.motion.affine[e * stride + i] = 0.0;
  }
  std::vector<double> impulse;  // velocities that only move positions have no momentum
  impulse.swap(s.motion.support_impulse);
  std::swap(s.motion.v, s.motion.moving);
  constrain(m, s, dt);
  std::swap(s.motion.v, s.motion.moving);
  impulse.swap(s.motion.support_impulse);
  constrain(m, s, dt);
  const auto lost = [&](int d, std::size_t slot) {
    const std::size_t k = d * stride + slot;
    const double back = 0.5 * dt * s.motion.inverse_mass[slot] * s.motion.force[k];  // to the time of the positions
    return -s.motion.mass[slot] * (s.motion.v[k] - kicked[k]) * (0.5 * (s.motion.v[k] + kicked[k]) - back);
  };
  for (int d = 0; d < 3; ++d)
    for (std::size_t i = 0; i < stride; ++i)
      if (s.motion.inverse_mass[i] > 0.0) s.book.transfer += lost(d, i);
  for (const auto& driven : m.constraints.driven)  // the energy of driven control points is booked at their support
    for (int d = 0; d < 3; ++d)
      for (const int slot : driven.slots[d])
        if (s.motion.inverse_mass[slot] > 0.0) s.book.transfer -= lost(d, slot);
}

}  // namespace sunder::shell
