#pragma once
// What forces still hold together, whatever the cracks say.
#include <vector>

#include "shell/solver/joining/stitching.h"
#include "shell/solver/state.h"

namespace sunder::shell {

/// Areas at rest [m^2] of the parts that forces still hold together, the largest first. Control points belong together
/// where a Gauss point that bears tension, a seam or a tie has both. A band that is fully damaged, or rubble, joins
/// nothing, though no crack runs through it, and has no area. Pieces that were handed off are left out.
std::vector<double> held_areas(const std::vector<ShellRef>& shells, const Stitching& stitching);

}  // namespace sunder::shell
