#pragma once
// Borders of CAD faces as polygons.
#include <vector>

#include "shell/geometry/patch.h"
#include "shell/geometry/trim_loops.h"
#include "shell/io/cad_file.h"

namespace sunder::shell {

/// The loops in the parameters of `to`, which is `from` with each parameter scaled.
std::vector<CadLoop> scaled_loops(const std::vector<CadLoop>& loops, const Patch& from, const Patch& to);

/// A polygon that encloses the area of the loop, with edges as cuts have them for elements of `spacing` [m]. What runs
/// on an edge of the patch is exactly there.
TrimLoop cad_loop(const CadLoop& loop, const Patch& patch, double spacing);

}  // namespace sunder::shell
