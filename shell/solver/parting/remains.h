#pragma once
// The held part of a shell when the shell is no longer solved.
#include "shell/solver/parting/handoff.h"

namespace sunder::shell {

/// Makes one static body of the held part, at its present place, and empties the shell. A part that is flat or has only
/// swung keeps its rest shape in a few convex parts. A curved or permanently bent part keeps its present shape, in
/// convex parts that are flat. It is drawn with both sides of its cracks; its convex parts are those of the uncut
/// patch, which span the gap of a crack that ends within the part.
Handoff freeze(const ShellModel& model, ShellState& state, const Triangulation& t, const std::vector<Piece>& pieces,
               BodyId id);

}  // namespace sunder::shell
