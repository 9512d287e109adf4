#pragma once
// Newton steps towards equilibrium, with the tangent of an uncracked shell.
#include <functional>
#include <vector>

#include "shell/solver/state.h"

namespace sunder::shell {

/// Numbers of the displacements that supports leave free: [3][plane], -1 held; tied ones share theirs.
struct FreeDegrees {
  std::vector<int> number;
  int count = 0;
};
FreeDegrees free_degrees(const ShellModel& model, const ShellState& state);

/// Solves K du = r for all free displacements, K the tangent at the present positions by differences of `forces`
/// (which puts them into state.motion.force). `residual` and the answer are [3][plane]; tied entries of `residual` are
/// summed. Empty where K has no factors. Only for states without cracks: control points that are moved
/// at once, 2 degree + 1 apart, must not interact.
std::vector<double> newton_step(const ShellModel& model, ShellState& state, const FreeDegrees& free,
                                const std::vector<double>& residual, const std::function<void()>& forces);

}  // namespace sunder::shell
