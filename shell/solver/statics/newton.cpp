#include "shell/solver/statics/newton.h"

namespace sunder::shell {

NewtonStep newton_step(const ShellModel& m, ShellState& s, const FreeDegrees& free, const std::vector<double>& residual,
                       Differences differences, const std::function<void()>& forces) {
  const Eigen::SparseMatrix<double> tangent = tangent_stiffness(m, s, free, differences, forces);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(free.count);
  for (std::size_t k = 0; k < residual.size(); ++k)
    if (free.number[k] >= 0) right[free.number[k]] = residual[k];
  NewtonStep out;
  Eigen::VectorXd step;
  if (m.loads.rotate_with_surface()) {  // the tangent is not symmetric
    Eigen::SparseLU<Eigen::SparseMatrix<double>> factors(tangent);
    if (factors.info() != Eigen::Success) return {};
    step = factors.solve(right);
  } else {
    // The mean of both triangles halves the round-off of differences, which is large for thin elements at a pole.
    const Eigen::SparseMatrix<double> mean = 0.5 * (tangent + Eigen::SparseMatrix<double>(tangent.transpose()));
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(mean);
    if (factors.info() != Eigen::Success) return {};
    step = factors.solve(right);
    out.unstable = (factors.vectorD().array() < 0.0).any();
  }
  if (!step.allFinite()) return {};
  out.u.assign(residual.size(), 0.0);
  for (std::size_t k = 0; k < residual.size(); ++k)
    if (free.number[k] >= 0) out.u[k] = step[free.number[k]];
  return out;
}

}  // namespace sunder::shell
