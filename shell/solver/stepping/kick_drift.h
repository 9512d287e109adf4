#pragma once
// Leapfrog: velocities take the forces of a substep, positions follow.
#include "shell/solver/state.h"

namespace sunder::shell {

/// Cracks change the force between the half kicks before and after them. The force must be that of the present
/// positions, which a substep of `dt` led to: that half kick is made one by the force before, so that the velocity
/// there is what it was. What leapfrog keeps (kinetic_energy) mostly falls by that, and what is lost is booked with
/// what the cracks released. Where it would rise, only the share of the change is taken that keeps it; what even so is
/// gained is taken from what the same cracks have released, and booked as injected where it is more, both in the first
/// shell's book. Shells that hang together have one share. `kick`
/// begins with it for a shell alone; before it energies and momenta are those of no moment.
void take_up_jump(const std::vector<ShellRef>& shells, double dt);
/// v += dt (f/m + gravity) and damping; force must be that of the present positions. Stiffness damping is
/// beta (f - last f) / dt = -beta K v. The work of damping is booked.
/// From the middle of the `last` substep to that of this one, of length `dt` [s]: in books closed at positions' times
/// half of each is its work.
void kick(const ShellModel& model, ShellState& state, const Vec3& gravity, double dt, double last);
inline void kick(const ShellModel& model, ShellState& state, const Vec3& gravity, double dt) {
  kick(model, state, gravity, dt, dt);
}
/// What loads and supports that move do now [W]. The work is booked by halves, before and after each kick.
double external_power(const ShellModel& model, const ShellState& state);
/// Velocities of what supports hold, tie together or drive, after kick and contact of a substep of `dt` that begins
/// at state.motion.time.
void constrain(const ShellModel& model, ShellState& state, double dt);
/// Positions, and state.motion.time, a substep on.
void drift(const ShellModel& model, ShellState& state, double dt);

}  // namespace sunder::shell
