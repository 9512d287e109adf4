#pragma once
// One substep of everything, stage by stage.
#include "shell/run/simulation.h"

namespace sunder::shell {

/// Moves the state on by `dt` [s]. Velocities, half the `last` substep behind positions, go on to half of this one
/// before them; then positions by `dt`. Throws Error (physics) from contact.
void substep(const Model& model, State& state, Scratch& scratch, double dt, double last);

/// Forces at the present positions: surface forms, stress, resultants, loads, fibres; seams share them. `last` is the
/// substep that led to these positions [s].
void internal_force(const Model& model, State& state, Scratch& scratch, double dt, double last);
/// Velocities take forces, loads and gravity.
void kick_all(const Model& model, State& state, Scratch& scratch, double dt, double last);
/// Impulses between shells and rigid bodies, and between bodies where substeps solve the engine's rows.
void rigid_contact(const Model& model, State& state, Scratch& scratch, double dt, double kicked);
/// Soft bodies against all else. Each step of theirs may last several substeps.
void soft_contact(const Model& model, State& state, Scratch& scratch, double dt);
/// Impulses between shells, on the grid.
void shell_contact(const Model& model, State& state, Scratch& scratch, double dt);
/// Seams, supports, and the background grid where the scene asks for it.
void constrain_all(const Model& model, State& state, Scratch& scratch, double dt);
/// Positions move on.
void drift_all(const Model& model, State& state, Scratch& scratch, double dt);

/// After substep k of n: fibres, cracks, cracks over seams. `clock` is at the start of the window.
void crack_update(const Model& model, State& state, Scratch& scratch, const Clock& clock, int k, int n, double dt);

}  // namespace sunder::shell
