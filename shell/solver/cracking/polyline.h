#pragma once
// Cuts that the scene prescribes.
#include <vector>

#include "shell/solver/cracking/criteria.h"

namespace sunder::shell {

/// Cuts are made at the start of the window in which they are due. Where tips run, their open ends may run on.
Criterion prescribed_cuts();

/// Cuts along a polyline in parameter space, in edges of about one spacing. Ends within a tenth of a spacing of the
/// border run out over it. Ends on another crack (to a fiftieth of a spacing) end just past it. Vertices of other
/// cracks so near to the polyline become its own. An edge that is there is not cut again. Where the last point is
/// exactly the first, the cut is closed and ends in the vertex where it began.
void insert_polyline(const ShellModel& model, ShellState& state, const std::vector<Vec2>& points, double time,
                     bool interlock = false);

}  // namespace sunder::shell
