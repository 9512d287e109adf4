#pragma once
// Cuts that somebody prescribes.
#include <vector>

#include "shell/solver/state.h"

namespace sunder::shell {

/// Cuts along a polyline in parameter space, in edges of about one spacing. Ends within a tenth of a spacing of the
/// border run out over it, ends on another crack (to a fiftieth of a spacing) just past it; vertices of other cracks
/// that it comes so near to are its own. An edge that is there is not cut again. Where the last point is exactly the
/// first the cut is closed, and ends in the vertex where it began.
void insert_polyline(const ShellModel& model, ShellState& state, const std::vector<Vec2>& points, double time);

}  // namespace sunder::shell
