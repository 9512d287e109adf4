#include "tests/validation/ritz.h"

namespace sunder::validation {

Eigenpairs ritz_pairs(const Eigen::MatrixXd& k, const Eigen::MatrixXd& m) {
  const Eigenpairs of_mass = eigenpairs(m);
  const Eigen::MatrixXd unit = of_mass.vectors * of_mass.values.cwiseSqrt().cwiseInverse().asDiagonal();
  Eigenpairs out = eigenpairs(unit.transpose() * k * unit);
  out.vectors = (unit * out.vectors).eval();
  return out;
}

}  // namespace sunder::validation
