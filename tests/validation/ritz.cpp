#include "tests/validation/ritz.h"

#include <stdexcept>

namespace sunder::validation {

Eigenpairs ritz_pairs(const Eigen::MatrixXd& k, const Eigen::MatrixXd& m) {
  const Eigenpairs of_mass = eigenpairs(m);
  if (!(of_mass.values.array() > 0.0).all()) {
    throw std::invalid_argument("ritz_pairs: the mass matrix is not positive definite");
  }
  const Eigen::MatrixXd unit = of_mass.vectors * of_mass.values.cwiseSqrt().cwiseInverse().asDiagonal();
  Eigenpairs out = eigenpairs(unit.transpose() * k * unit);
  out.vectors = (unit * out.vectors).eval();
  return out;
}

}  // namespace sunder::validation
