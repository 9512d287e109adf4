#pragma once
// Decompositions of dense matrices. One file includes Eigen's, because each takes seconds to compile.
#include <Eigen/Core>
#include <optional>

#include "coupler/core/vec.h"

namespace sunder {

/// A symmetric matrix as vectors * values.asDiagonal() * vectors.transpose().
struct Eigenpairs {
  Eigen::VectorXd values;   // ascending, in the matrix' unit
  Eigen::MatrixXd vectors;  // [column][value]: orthonormal
};

/// The same of a matrix of two rows.
struct PlaneEigenpairs {
  Vec2 values;
  Eigen::Matrix2d vectors;
};

/// Eigenvalues and eigenvectors of a symmetric matrix n x n. Only its lower triangle is read.
Eigenpairs eigenpairs(const Eigen::MatrixXd& symmetric);
PlaneEigenpairs plane_eigenpairs(const Eigen::Matrix2d& symmetric);

/// Eigenvalues alone, ascending. Only the lower triangle is read.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& symmetric);

/// Eigenvalues, ascending, of the symmetric tridiagonal matrix with this diagonal of n and the n - 1 values `beside`
/// it.
Eigen::VectorXd tridiagonal_eigenvalues(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& beside);

/// X of A X = B, for a regular A (n x n) and B (n x k), by elimination with partial pivoting.
Eigen::MatrixXd solved(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// X of A X = B, for a symmetric, definite A. Only the lower triangle of A is read.
Mat3 solved_symmetric(const Mat3& a, const Mat3& b);

/// The shortest of all x for which |A x - b| is least, for A (m x n) of any rank.
Eigen::VectorXd shortest_fit(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

/// X (n x k) for which |A X - B| is least, for A (m x n). Nothing where A has less than its full rank n: where, by
/// columns in the order of what they add, one adds less than `threshold` of the first.
std::optional<Eigen::MatrixXd> fit(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, double threshold);

/// Orthonormal columns (m x n) that span what the columns of A (m x n) span, which are independent.
Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& a);

}  // namespace sunder
