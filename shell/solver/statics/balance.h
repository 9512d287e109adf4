#pragma once
// The forces that a search for equilibrium brings into balance.
#include <algorithm>
#include <vector>

#include <Eigen/SparseCholesky>

#include "shell/solver/statics/joined.h"

namespace sunder::shell {

/// Unbalanced forces of a shell, or of several that seams join, at a share of the way to their loads. At share 0 the
/// shells are in balance where the search began: what is unbalanced there is taken off, and supports that move are at
/// their old place. At share 1 all loads act, and supports are at their place at state.motion.time. Loads that turn
/// with the surface have the share of what they gain by turning. Vectors are fields (JoinedDegrees).
class Balance {
 public:
  /// `joined` and its states must outlive it. The search begins at the present positions.
  Balance(const JoinedShells& joined, int threads);

  /// Goes to a share of the loads, 0 to 1, and moves driven control points in x to their places there.
  void go_to(double share);
  /// Computes `force` with weights at x, and gives x to the states.
  void compute();
  /// The same of one shell at the positions of its state, into its state: for differences.
  void compute(std::size_t shell);
  /// Calls f with the number of each shell, several at the same time.
  template <class F>
  void each_shell(F&& f) const {
    const auto shells = static_cast<int>(joined_.shells.size());
#pragma omp parallel for schedule(dynamic, 1) num_threads(std::min(threads_, shells)) if (shells > 1)
    for (int k = 0; k < shells; ++k) f(static_cast<std::size_t>(k));
  }
  /// Returns the norm of unbalanced forces, divided by that of loads and weights, or of reactions where these are
  /// larger; not a number where forces are not. What constraints of seams bear is in balance. Call compute() before.
  /// `summed` gets the unbalanced forces [N]; every member of a tied group holds its sum.
  double residual(std::vector<double>& summed);
  /// Returns the residual that round-off leaves: the change of forces, as residual() measures them, when each
  /// coordinate changes by a unit in its last place. Call compute() before.
  double round_off();
  /// Sums the forces of each tied group; every member then holds the sum. Those of dependent control points go to the
  /// ones that they depend on.
  void gather(std::vector<double>& force) const;
  /// Takes from gathered forces what the constraints of seams bear, so that accelerations by `inverse` keep them.
  void take_off(std::vector<double>& force);
  /// Moves x by displacements that bring the constraints of seams back.
  void close();
  /// Largest violation of the constraints of seams [-].
  double open() const;
  /// Work of the unbalanced forces on a step, without what constraints bear [J]. Call residual() before.
  double work_on(const std::vector<double>& step) const;
  /// Work of the loads and weights on the way from `start` to x [J].
  double work_from(const std::vector<double>& start) const;
  /// Positions at which the search began [m].
  const std::vector<double>& start() const { return start_; }
  const JoinedDegrees& degrees() const { return degrees_; }
  const JoinedShells& joined() const { return joined_; }
  /// Of the constraints of seams, in the last residual() [N m].
  const Eigen::VectorXd& multipliers() const { return multipliers_; }
  bool rotates() const;  // loads turn with the surface

  std::vector<double> x, force;  // [m], [N]
  /// Row sums of the stiffness [N/m]. As masses they give every control point a similar step.
  std::vector<double> mass;
  /// Inverse of `mass`, of the sum in a tied group; 0: not free.
  std::vector<double> inverse;

 private:
  double scale() const;
  Eigen::VectorXd multipliers_of(const Eigen::VectorXd& force);
  double external(std::size_t entry) const { return loads_.empty() ? 0.0 : loads_[entry]; }
  const JoinedShells& joined_;
  JoinedDegrees degrees_;
  int threads_;
  double share_ = 1.0;
  std::vector<double> weight_, start_;
  std::vector<double> loads_;       // in `force` [N]; empty: none
  std::vector<double> unbalanced_;  // at the start [N]; empty: not needed yet
  std::vector<double> external_;    // loads at the start [N]; empty: they do not turn with the surface
  Eigen::VectorXd inverse_, multipliers_;
  Eigen::SparseMatrix<double> gradients_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors_;
};

}  // namespace sunder::shell
