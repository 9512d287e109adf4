#pragma once
// The tangent stiffness of an uncracked shell, by differences of its forces.
#include <functional>
#include <vector>

#include <Eigen/Sparse>

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

/// How the tangent stiffness is found. Central differences cost twice as much as one-sided ones. Thin shells that bend
/// far need them. The fourth order costs four times as much: it is for frequencies, where the stiffness against bending
/// must come out right beside that against stretch, which is larger by (span / thickness) squared and more.
enum class Differences { kOneSided, kCentral, kFourthOrder };

/// Returns the tangent stiffness K [N/m] of all free displacements at the present positions, by differences of
/// `forces`, which computes state.motion.force [N]. state.motion.force is left at the present positions. Only for
/// states without cracks: control points 2 degree + 1 apart move together and must not interact.
Eigen::SparseMatrix<double> tangent_stiffness(const ShellModel& model, ShellState& state, const FreeDegrees& free,
                                              Differences differences, const std::function<void()>& forces);

}  // namespace sunder::shell
