#pragma once
// What a support holds when a shell is no longer solved.
#include "shell/solver/parting/handoff.h"

namespace sunder::shell {

/// What a support holds as one static body where it stands; the shell is then empty. What has stayed flat, or only
/// swung, keeps its rest shape in few convex parts; what is curved or bent for good stands as it is, a part for each
/// triangle.
Handoff freeze(const ShellModel& model, ShellState& state, const Triangulation& t, const std::vector<Piece>& pieces,
               BodyId id);

}  // namespace sunder::shell
