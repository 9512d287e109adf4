#pragma once
// Check that positions and velocities are numbers. An unstable shell is found within a few substeps, at its place.
#include "shell/solver/state.h"

namespace sunder::shell {

constexpr int kFiniteInterval = 8;  // substeps between two checks

/// Throws Error (unstable) where a control point's position or velocity is not finite. The message names the shell, the
/// place and the time [s].
void check_finite(const ShellModel& model, const ShellState& state, double time);

}  // namespace sunder::shell
