#pragma once
// Release of supports at a time of their own.
#include "shell/solver/state.h"

namespace sunder::shell {

/// Gives the model the supports of a stage of model.releases.
void take_stage(ShellModel& model, int stage);
/// Releases the supports of the next stage: control points that no other support holds move from now on. A point that
/// was driven goes on with its velocity. Energy and momentum stay as they are: what held or driven points have of them
/// counts from now on, and is booked as work of the supports. `dt` [s] is the last substep.
void release(ShellModel& model, ShellState& state, const Vec3& gravity, double dt);

}  // namespace sunder::shell
