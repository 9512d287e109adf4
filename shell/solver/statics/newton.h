#pragma once
// Newton steps towards equilibrium, with the tangent stiffness of an uncracked shell.
#include <functional>
#include <vector>

#include "shell/solver/statics/balance.h"
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

/// Returns the tangent stiffness of all free displacements of joined shells at balance.x, after balance.compute().
Eigen::SparseMatrix<double> joined_stiffness(Balance& balance, Differences differences);

/// The same for joined shells at balance.x, after balance.residual(), which gave `residual`. The step also brings
/// constraints of seams back.
NewtonStep newton_step(Balance& balance, const std::vector<double>& residual, Differences differences);

}  // namespace sunder::shell
