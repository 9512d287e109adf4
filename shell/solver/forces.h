#pragma once
// Forces and energies of one shell at its present positions.
#include "shell/solver/state.h"

namespace sunder::shell {

/// Returns views of the layer states and the law of a shell that yields.
RowPlasticity plasticity_of(const ShellModel& model, ShellState& state);

/// Computes the forces at the present positions into state.motion.force [N]: rows, gathered points, crack faces,
/// interlayer, and loads at state.motion.time. Returns the elastic energy [J] where `energy` is true, otherwise 0.
/// `stress_share` is the weight of the new stress in the running mean; 0: no stress is recorded. Damage and plastic
/// flow advance only where it is positive, and their dissipation is booked. With 0 the forces are those of a trial step
/// from the stored states.
double compute_forces(const ShellModel& model, ShellState& state, bool energy, double stress_share, int threads);

/// Forces of a substep, as by compute_forces() without energy: a shell that yields advances also where `stress_share`
/// is 0, since nobody reads its stress.
void advance_forces(const ShellModel& model, ShellState& state, double stress_share, int threads);

/// Multiplies forces, loads and the force discontinuity of new cracks by a factor: the impulse of several substeps.
void scale_forces(ShellState& state, double factor);
/// Sets forces and loads to zero, in a substep without a force evaluation.
void clear_forces(ShellState& state);

/// Returns the kinetic energy [J] at the time of the positions: m v- . v+ / 2. v- are the stored velocities, v+ those
/// after a kick of `dt` [s]. With the elastic energy of a linear shell, leapfrog conserves this sum to round-off at any
/// stable step. It does not conserve (v- + v+)^2 / 8, which is far too large for the stiffest modes near the stable
/// step. A driven control point counts m v-^2 / 2, as forces do not move it.
double kinetic_energy(const ShellModel& model, const ShellState& state, double dt);

/// Returns the potential energy of free control points in the field of gravity [J].
double potential_energy(const ShellModel& model, const ShellState& state, const Vec3& gravity);

}  // namespace sunder::shell
