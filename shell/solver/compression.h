#pragma once
// Sheets with a negative Poisson's ratio, compressed further than plane stress has an answer for.
#include "shell/solver/state.h"

namespace sunder::shell {

/// Substeps between two looks; between them such a point bears what it bears at the limit.
constexpr int kCompressionInterval = 8;

/// Throws Error (physics) with the place and the area ratio where a layer is compressed beyond what its Poisson's ratio
/// permits (find_least_log_area). Costs nothing where all is permitted.
void check_compression(const ShellModel& model, const ShellState& state);

}  // namespace sunder::shell
