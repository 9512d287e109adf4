#pragma once
// Newton steps towards equilibrium, with the tangent stiffness of an uncracked shell.
#include <functional>
#include <vector>

#include "shell/solver/state.h"

namespace sunder::shell {

/// Numbers of the free displacements, [3][component stride]: -1 where a support holds or drives it; tied slots share
/// one number.
struct FreeDegrees {
  std::vector<int> number;
  int count = 0;
};
/// Numbers the free displacements of a shell.
FreeDegrees free_degrees(const ShellModel& model, const ShellState& state);

/// Solves K du = r for all free displacements [m]. K is the tangent stiffness at the present positions, by differences
/// of `forces`, which computes state.motion.force [N]. `residual` and the result are [3][component stride]; tied
/// entries of `residual` hold their sum. Returns nothing where K cannot be factorised. Only for states without cracks:
/// control points 2 degree + 1 apart move together and must not interact.
std::vector<double> newton_step(const ShellModel& model, ShellState& state, const FreeDegrees& free,
                                const std::vector<double>& residual, const std::function<void()>& forces);

}  // namespace sunder::shell
