#pragma once
// The forces that a search for equilibrium brings into balance.
#include <vector>

#include "shell/solver/state.h"

namespace sunder::shell {

/// Unbalanced forces of a shell at a share of the way to its loads. At share 0 the shell is in balance where the search
/// began: what is unbalanced there is taken off, and supports that move are at their old place. At share 1 all loads
/// act, and supports are at their place at state.motion.time. Loads that turn with the surface have the share of what
/// they gain by turning. Vectors are [3][component stride].
class Balance {
 public:
  /// `model` and `state` must outlive it. The search begins at the present positions. `gravity` in m/s^2.
  Balance(const ShellModel& model, ShellState& state, const Vec3& gravity, int threads);

  /// Goes to a share of the loads, 0 to 1, and moves driven control points to their places there.
  void go_to(double share);
  /// Computes state.motion.force [N], with weights, at the present positions.
  void compute();
  /// Returns the norm of unbalanced forces, divided by that of loads and weights, or of reactions where these are
  /// larger; not a number where forces are not. Call compute() before. `summed` gets the forces [N]; every member of a
  /// tied group holds its sum.
  double residual(std::vector<double>& summed) const;
  /// Returns the residual that round-off leaves: the change of forces, as residual() measures them, when each
  /// coordinate changes by a unit in its last place. Call compute() before.
  double round_off();
  /// Sums the forces of each tied group; every member then holds the sum.
  void gather(std::vector<double>& force) const;
  /// Work of the loads and weights on the way from `start` to the present positions [J].
  double work_from(const std::vector<double>& start) const;
  /// Positions at which the search began [m].
  const std::vector<double>& start() const { return start_; }

  /// Row sums of the stiffness, one a slot [N/m]. As masses they give every control point a similar step.
  std::vector<double> mass;
  /// Inverse of `mass`, of the sum in a tied group; 0: not free.
  std::vector<double> inverse;

 private:
  double scale() const;
  const ShellModel& m_;
  ShellState& s_;
  int threads_;
  double share_ = 1.0;
  std::vector<double> weight_, start_;
  std::vector<double> unbalanced_;  // at the start [N]; empty: not needed yet
  std::vector<double> external_;    // loads at the start [N]; empty: they do not turn with the surface
};

}  // namespace sunder::shell
