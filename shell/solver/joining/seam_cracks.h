#pragma once
// Propagation of cracks over a seam into the next shell.
#include "shell/solver/joining/stitching.h"

namespace sunder::shell {

/// Propagates cracks over seams. A tip that has run out of a shell at a seam continues in the other shell if that one
/// can crack (`can_crack`, by shell). The angle to the seam stays the same. The first edge is cut at `time` [s]; its
/// new tip then runs by itself. Control points that a seam joins across a crack are released, for prescribed cuts too,
/// and ties along trims are made anew.
/// Returns the number of cracks that crossed a seam.
int propagate_over_seams(const std::vector<Seam>& seams, const std::vector<ShellRef>& shells,
                         const std::vector<char>& can_crack, Stitching& stitching, double time);

/// Starts a crack at parameter `at` on the border of a shell, with its first edge `edge`, which a tip of another shell
/// continues. That tip has run `behind` [m] past its border.
void start_beyond(const ShellModel& model, ShellState& state, const Vec2& at, const Vec2& edge, const Tip& from,
                  double behind, double time);

/// Releases all control points that seams on an edge of a shell join, from share `from` of the edge to share `to`.
void release_seams(const std::vector<Seam>& seams, const std::vector<ShellRef>& shells, Stitching& stitching, int shell,
                   int edge, double from, double to);

}  // namespace sunder::shell
