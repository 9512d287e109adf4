#include "coupler/core/dense.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace sunder {
namespace {

Eigen::MatrixXd hilbert(int rows, int columns) {
  Eigen::MatrixXd a(rows, columns);
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) a(i, j) = 1.0 / (1.0 + i + j);
  return a;
}

TEST(Dense, EigenvaluesAreThoseOfASpringChain) {
  const int n = 7;  // fixed at both ends: 2 - 2 cos(k pi / (n + 1))
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
  a.diagonal().setConstant(2.0);
  a.diagonal(-1).setConstant(-1.0);  // the upper triangle is not read
  const Eigenpairs found = eigenpairs(a);
  const Eigen::VectorXd alone = eigenvalues(a), bands = tridiagonal_eigenvalues(a.diagonal(), a.diagonal(-1));
  for (int k = 0; k < n; ++k) {
    const double exact = 2.0 - 2.0 * std::cos((k + 1) * std::numbers::pi / (n + 1));
    EXPECT_NEAR(found.values[k], exact, 1e-14);
    EXPECT_NEAR(alone[k], exact, 1e-14);
    EXPECT_NEAR(bands[k], exact, 1e-14);
  }
  const Eigen::MatrixXd whole = a.selfadjointView<Eigen::Lower>();
  EXPECT_LT((whole * found.vectors - found.vectors * found.values.asDiagonal()).norm(), 1e-13);
}

TEST(Dense, EigenpairsInThePlaneAreOrthonormalAndAscend) {
  Eigen::Matrix2d a;
  a << 2.0, 1.0, 1.0, 2.0;
  const PlaneEigenpairs found = plane_eigenpairs(a);
  EXPECT_NEAR(found.values[0], 1.0, 1e-15);
  EXPECT_NEAR(found.values[1], 3.0, 1e-15);
  EXPECT_NEAR(std::abs(found.vectors.col(1).dot(Vec2(1.0, 1.0))), std::numbers::sqrt2, 1e-15);
}

TEST(Dense, SolvesForSeveralRightSidesAtOnce) {
  Eigen::MatrixXd a(3, 3);
  a << 0.0, 2.0, 1.0, 1.0, 0.0, 3.0, 2.0, 1.0, 0.0;  // needs pivots
  const Eigen::MatrixXd x = hilbert(3, 2);
  EXPECT_LT((solved(a, a * x) - x).norm(), 1e-15);
}

TEST(Dense, SolvesSymmetricSystemsFromTheLowerTriangle) {
  Mat3 a;
  a << 4.0, 9.0, 9.0, 1.0, 5.0, 9.0, 2.0, 3.0, 6.0;  // 9: not read
  const Mat3 whole = a.selfadjointView<Eigen::Lower>(), x = hilbert(3, 3);
  EXPECT_LT((solved_symmetric(a, whole * x) - x).norm(), 1e-14);
}

TEST(Dense, TheShortestFitOfTooFewEquationsIsNormalToWhatTheyLeaveFree) {
  Eigen::MatrixXd a(1, 3);
  a << 1.0, 2.0, 2.0;
  EXPECT_LT((shortest_fit(a, Eigen::VectorXd::Constant(1, 9.0)) - Eigen::Vector3d(1.0, 2.0, 2.0)).norm(), 1e-14);
}

TEST(Dense, AFitIsNormalToItsMisfitAndIsNoneWhereColumnsDepend) {
  const Eigen::MatrixXd a = hilbert(6, 3), b = Eigen::MatrixXd::Ones(6, 2);
  const auto x = fit(a, b, 1e-12);
  ASSERT_TRUE(x);
  EXPECT_LT((a.transpose() * (a * *x - b)).norm(), 1e-13);
  Eigen::MatrixXd dependent = a;
  dependent.col(2) = dependent.col(0) - 2.0 * dependent.col(1);
  EXPECT_FALSE(fit(dependent, b, 1e-12));
}

TEST(Dense, OrthonormalColumnsSpanTheSame) {
  const Eigen::MatrixXd a = hilbert(6, 3), q = orthonormal(a);
  EXPECT_LT((q.transpose() * q - Eigen::MatrixXd::Identity(3, 3)).norm(), 1e-14);
  EXPECT_LT((a - q * (q.transpose() * a)).norm(), 1e-14);
}

}  // namespace
}  // namespace sunder
