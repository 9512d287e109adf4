#pragma once
// Forces and energies of one shell at its present positions.
#include "shell/solver/state.h"

namespace sunder::shell {

/// Views on the layer states and the law of a shell that yields.
RowPlasticity plasticity_of(const ShellModel& model, ShellState& state);

/// Forces at the present positions into state.motion.force [N]: rows, gathered points, crack faces, interlayer, and
/// loads at state.motion.time. Returns the elastic energy [J] where `energy`, else 0.
/// Damage and plastic flow move on only where stress is recorded, `stress_share` > 0 (share of the new stress in the
/// running mean); else the answer is that of a step from where they stand. Books what they dissipate.
double compute_forces(const ShellModel& model, ShellState& state, bool energy, double stress_share, int threads);

/// Kinetic energy [J] at the time of the positions: m v- . v+ / 2, v- the stored velocities and v+ those a
/// kick of `dt` later. With the elastic energy of a linear shell it is what leapfrog keeps to round-off, at
/// any stable step; (v- + v+)^2 / 8 is not: at 0.8 of the stable step it gives the stiffest mode 1.6 times
/// its elastic energy too much. A control point that a support drives counts with m v-^2 / 2: no force moves it.
double kinetic_energy(const ShellModel& model, const ShellState& state, double dt);

/// Energy of free control points in the field of gravity [J].
double potential_energy(const ShellModel& model, const ShellState& state, const Vec3& gravity);

}  // namespace sunder::shell
