#include "coupler/core/principal_axes.h"

#include <Eigen/Eigenvalues>

namespace sunder {

PrincipalAxes principal_axes(const Mat3& tensor) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(tensor);
  PrincipalAxes out{solver.eigenvalues(), solver.eigenvectors()};
  if (out.axes.determinant() < 0.0) out.axes.col(2) = -out.axes.col(2);
  return out;
}

}  // namespace sunder
