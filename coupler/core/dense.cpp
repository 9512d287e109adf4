#include "coupler/core/dense.h"

#include <Eigen/Dense>

namespace sunder {

Eigenpairs eigenpairs(const Eigen::MatrixXd& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

PlaneEigenpairs plane_eigenpairs(const Eigen::Matrix2d& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, Eigen::EigenvaluesOnly).eigenvalues();
}

Eigen::VectorXd tridiagonal_eigenvalues(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& beside) {
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(diagonal, beside, Eigen::EigenvaluesOnly);
  return solver.eigenvalues();
}

Eigen::MatrixXd solved(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return a.partialPivLu().solve(b); }

Mat3 solved_symmetric(const Mat3& a, const Mat3& b) { return a.ldlt().solve(b); }

Eigen::VectorXd shortest_fit(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.completeOrthogonalDecomposition().solve(b);
}

std::optional<Eigen::MatrixXd> fit(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, double threshold) {
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> solver(a);
  solver.setThreshold(threshold);
  if (solver.rank() < a.cols()) return std::nullopt;
  return solver.solve(b);
}

Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& a) {
  return Eigen::HouseholderQR<Eigen::MatrixXd>(a).householderQ() * Eigen::MatrixXd::Identity(a.rows(), a.cols());
}

}  // namespace sunder
