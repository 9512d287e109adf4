#pragma once
// Cracks from damage, the paper's way (5.1, 5.2): the stress damages and heals, what has been fully damaged
// is a region, and the region's middle line becomes the crack.
#include "shell/solver/state.h"

namespace sunder::shell {

/// Hands the Gauss points that come near their strength to the damage law. Call with the stress of the
/// present substep, not a mean over time.
void watch_stress(const ShellModel& model, ShellState& state);

/// Adds the middle lines of what was fully damaged since the last call to the cracks: tips go on, branches
/// join their stems, ends near the border run out. Earlier cracks stay as they are. Returns edges inserted.
int extract_cracks(const ShellModel& model, ShellState& state, double time);

}  // namespace sunder::shell
