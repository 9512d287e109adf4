#pragma once
// Parts that internal forces still connect. Crack edges are not consulted.
#include <vector>

#include "shell/solver/joining/stitching.h"
#include "shell/solver/state.h"

namespace sunder::shell {

/// Areas at rest [m^2] of the parts that internal forces still connect, the largest first. Two control points belong to
/// one part if a Gauss point in tension, a seam or a tie uses both. A fully damaged band or rubble connects nothing,
/// even where no crack runs through it, and has no area. Pieces that were handed off are left out.
std::vector<double> held_areas(const std::vector<ShellRef>& shells, const Stitching& stitching);

}  // namespace sunder::shell
