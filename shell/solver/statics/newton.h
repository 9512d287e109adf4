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

/// How the tangent stiffness is found. Central differences cost twice as much. Thin shells that bend far need them.
enum class Differences { kOneSided, kCentral };

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
