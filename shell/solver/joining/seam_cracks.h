#pragma once
// Cracks that run over a seam from one shell into the next.
#include "shell/solver/joining/stitching.h"

namespace sunder::shell {

/// Ends of cracks that have run out of a shell where it hangs together with another one that can crack (`can_crack`, by
/// shell) go on there, at the same angle to the seam: the first edge is cut at `time` [s], and its end runs on by
/// itself. What a seam ties across a crack that reaches it, cuts of the scene too, is let go. Returns the number of
/// cracks that went on.
int carry_on(const std::vector<Seam>& seams, const std::vector<ShellRef>& shells, const std::vector<char>& can_crack,
             Stitching& stitching, double time);

/// Lets go of all that the seams on an edge of a shell tie from share `from` of the edge to `to`.
void open_seams(const std::vector<Seam>& seams, const std::vector<ShellRef>& shells, Stitching& stitching, int shell,
                int edge, double from, double to);

}  // namespace sunder::shell
