#pragma once
// One substep of the whole simulation, stage by stage.
#include "shell/run/simulation.h"

namespace sunder::shell {

/// Advances the state by `dt` [s]; `last` is the substep before [s], 0 at the start of a run. Velocities of shells are
/// those of half a `last` before the positions; they advance to half a `dt` after them, then positions advance by `dt`.
/// Velocities of bodies are of the same times. Throws Error (physics) from contact.
void substep(const Model& model, State& state, Scratch& scratch, double dt, double last);

/// Computes forces at the present positions: surface forms, stress, resultants, loads, fibres. Seams pass forces to
/// independent control points. `last` is the substep that led to these positions [s].
void internal_force(const Model& model, State& state, Scratch& scratch, double dt, double last);
/// Adds forces, loads and gravity to velocities.
void kick_all(const Model& model, State& state, Scratch& scratch, double dt, double last);
/// Applies impulses between shells and rigid bodies, and between bodies where substeps solve the engine's rows.
/// `kicked` is the time over which velocities were kicked [s].
void rigid_contact(const Model& model, State& state, Scratch& scratch, double dt, double kicked);
/// Steps soft bodies against all others. One of their steps may span several substeps.
void soft_contact(const Model& model, State& state, Scratch& scratch, double dt);
/// Applies impulses between shells, on the grid.
void shell_contact(const Model& model, State& state, Scratch& scratch, double dt);
/// Applies seams and supports, and the transfer through the background grid where the scene asks for it.
void constrain_all(const Model& model, State& state, Scratch& scratch, double dt);
/// Advances positions by `dt` [s].
void drift_all(const Model& model, State& state, Scratch& scratch, double dt);

/// Gives each shell the mean force of its local time step, once it and those that seams join to it are in step.
void average_forces(State& state);

/// Updates cracks after substep k of n: tips, cracks from damage, cracks over seams. `clock` is at the start of the
/// window.
void crack_update(const Model& model, State& state, Scratch& scratch, const Clock& clock, int k, int n, double dt);

}  // namespace sunder::shell
