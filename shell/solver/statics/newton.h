#pragma once
// Newton steps towards equilibrium, with the tangent stiffness of an uncracked shell.
#include <functional>
#include <vector>

#include "shell/solver/statics/tangent.h"

namespace sunder::shell {

struct NewtonStep {
  std::vector<double> u;  // [3][component stride] [m]; empty: K cannot be factorised
  bool unstable = false;  // K has a negative eigenvalue; not known where loads turn with the surface
};
/// Solves K u = r for all free displacements. K is the tangent stiffness at the present positions, by differences of
/// `forces`, which computes state.motion.force [N]. `residual` is [3][component stride]; its tied entries hold their
/// sum. Only for states without cracks: control points 2 degree + 1 apart move together and must not interact.
NewtonStep newton_step(const ShellModel& model, ShellState& state, const FreeDegrees& free,
                       const std::vector<double>& residual, Differences differences,
                       const std::function<void()>& forces);

}  // namespace sunder::shell
