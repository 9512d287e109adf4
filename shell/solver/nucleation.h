#pragma once
// Cracks that start: by the strength of the faces, and only where they would run on.
#include "shell/solver/crack_rules.h"

namespace sunder::shell {

/// Starts cracks where a face exceeds the local strength, most overstressed first. Returns the number of edges
/// inserted. `random` is advanced only where chance has to decide a direction.
int nucleate(const ShellModel& model, ShellState& state, const CrackRules& rules, double time, std::uint64_t& random);

}  // namespace sunder::shell
