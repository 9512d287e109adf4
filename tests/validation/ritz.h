#pragma once
#include "coupler/core/dense.h"

namespace sunder::validation {

/// Eigenpairs of K x = value M x for symmetric K and positive definite M (n x n), such that the vectors hold
/// xᵀ M x = 1: Ritz's method on a subspace.
Eigenpairs ritz_pairs(const Eigen::MatrixXd& k, const Eigen::MatrixXd& m);

}  // namespace sunder::validation
