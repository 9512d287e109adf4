#include "shell/solver/release.h"

namespace sunder::shell {
namespace {

// Half a kick of gravity on control points that are driven along some axes [J]: the energy of a shell leaves it out.
double kick_of_driven(const ShellModel& m, const ShellState& s, const Vec3& gravity, double dt) {
  double sum = 0.0;
  for (const auto& driven : m.constraints.driven)
    for (int d = 0; d < 3; ++d)
      for (const int slot : driven.slots[d])
        if (s.motion.inverse_mass[slot] > 0.0) sum += 0.5 * dt * s.motion.mass[slot] * gravity[d] * s.velocity(slot)[d];
  return sum;
}

}  // namespace

void take_stage(ShellModel& m, int stage) {
  const SupportStage& s = m.releases[stage];
  m.constraints = s.constraints, m.held = s.held, m.clamped = s.clamped;
}

void release(ShellModel& m, ShellState& s, const Vec3& gravity, double dt) {
  s.book.external += kick_of_driven(m, s, gravity, dt);
  take_stage(m, s.motion.released++);
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    if (m.held[slot] || m.trim.drops(slot) || s.motion.detached[slot] || s.motion.inverse_mass[slot] > 0.0) continue;
    const double mass = s.motion.mass[slot];
    if (!(mass > 0.0)) continue;
    s.motion.inverse_mass[slot] = 1.0 / mass;
    const Vec3 v = s.velocity(slot);
    s.book.external += mass * (0.5 * v.squaredNorm() + 0.5 * dt * gravity.dot(v) - gravity.dot(s.position(slot)));
  }
  s.book.external -= kick_of_driven(m, s, gravity, dt);
}

}  // namespace sunder::shell
