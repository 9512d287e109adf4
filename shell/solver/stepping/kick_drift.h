#pragma once
// Leapfrog: forces change velocities, then velocities change positions.
#include "shell/solver/state.h"

namespace sunder::shell {

/// Applies the force discontinuity of new cracks. Cracks change the force between the half kick before them and the
/// half kick after them. The half kick that led to the present positions, of a substep `dt` [s], is repeated with the
/// force before the cracks. So the velocity at these positions does not change. The force must be that of the
/// present positions. The energy that leapfrog conserves (kinetic_energy) mostly falls; the loss is booked with the
/// energy that the cracks released. Where it would rise, only the share of the discontinuity that conserves it is
/// applied. Remaining gains are charged to the energy that the same cracks released. Any excess is booked as
/// `injected`. Both entries go to the first shell's book. Shells that are joined have one common share. For a single
/// shell `kick` does this first. Until then, energy and momentum refer to two different times.
void apply_force_discontinuity(const std::vector<ShellRef>& shells, double dt);
/// Updates velocities: v += dt (f/m + gravity), and damping. The force must be that of the present positions. Stiffness
/// damping is beta (f - last f) / dt = -beta K v. The work of damping is booked. The kick leads from the middle of the
/// `last` substep to the middle of the substep `dt` [s]. Books close at the times of positions, so half of each is its
/// work.
void kick(const ShellModel& model, ShellState& state, const Vec3& gravity, double dt, double last);
inline void kick(const ShellModel& model, ShellState& state, const Vec3& gravity, double dt) {
  kick(model, state, gravity, dt, dt);
}
/// Returns the power [W] of loads and moving supports. Half of the work is booked before each kick and half after it.
double external_power(const ShellModel& model, const ShellState& state);
/// Sets velocities of control points that supports hold, tie or drive. Call it after kick and contact of a substep of
/// `dt` [s] that begins at state.motion.time.
void constrain(const ShellModel& model, ShellState& state, double dt);
/// Advances positions and state.motion.time by `dt` [s].
void drift(const ShellModel& model, ShellState& state, double dt);

}  // namespace sunder::shell
