#pragma once
// Check of sheets with a negative Poisson's ratio: beyond a limit of compression, plane stress has no solution.
#include "shell/solver/state.h"

namespace sunder::shell {

/// Substeps between two checks. Until the next check such a point bears the stress at the limit.
constexpr int kCompressionInterval = 8;

/// Throws Error (physics) where a layer is compressed beyond the limit of its Poisson's ratio
/// (Elasticity::least_log_area); the message has place and area ratio. Returns at once where there is no limit.
void check_compression(const ShellModel& model, const ShellState& state);

}  // namespace sunder::shell
