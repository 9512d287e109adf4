#pragma once
// Cracks as lines of a frame.
#include <functional>
#include <vector>

#include "shell/io/vtp.h"
#include "shell/solver/parting/handoff.h"

namespace sunder::shell {

/// Returns the cracks of shell number `shell`. They lie on the middle surface at rest, so that they fit any frame. On
/// an interlayer they lie where it is now, but for those that a body has taken along.
std::vector<DrawnLine> crack_lines(const ShellModel& model, const ShellState& state, int shell);

/// Returns those cracks of a laminate that a body takes along, where they are now: the control point nearest to each
/// has a slot for which `leaves` is true.
std::vector<DrawnLine> leaving_lines(const ShellModel& model, const ShellState& state, int shell,
                                     const std::function<bool(int slot)>& leaves);

/// Returns these lines as seen from a body that is at this place and has this orientation.
std::vector<DrawnLine> seen_from(const BodyMotion& body, std::vector<DrawnLine> lines);

/// Adds to `lines`, which are in the world, those that a body carries.
void add_carried(const BodyMotion& body, const std::vector<DrawnLine>& carried, std::vector<DrawnLine>& lines);

/// Point arrays `displacement`, `parameter`, of the graph itself, also beyond the border, with a third component of 0;
/// cell arrays `crack`, `time` and `shell`.
VtpMesh line_mesh(const std::vector<DrawnLine>& lines);

}  // namespace sunder::shell
