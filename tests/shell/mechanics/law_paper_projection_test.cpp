// The closed form of the paper's in-plane stress, against its system of nine equations as it is printed.
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "shell/mechanics/laws.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// A surface element: tangents and the unit normal as columns.
Mat3 base(const Vec3& u, const Vec3& v) {
  Mat3 g;
  g.col(0) = u, g.col(1) = v, g.col(2) = u.cross(v).normalized();
  return g;
}

Sym2<double> metric(const Mat3& g) { return {g.col(0).dot(g.col(0)), g.col(1).dot(g.col(1)), g.col(0).dot(g.col(1))}; }

// Components sigma^ij by eq. 10-12: the columns of the matrix are vec(g_i (x) g_j). (The paper prints them as rows;
// then eq. 10 does not hold.) Returned as a 3 x 3 matrix.
Mat3 components_by_nine_equations(const Mat3& g, const Mat3& sigma) {
  Eigen::Matrix<double, 9, 9> system;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const Mat3 product = g.col(i) * g.col(j).transpose();
      system.col(3 * i + j) = product.reshaped<Eigen::RowMajor>();
    }
  const Eigen::Matrix<double, 9, 1> found = system.fullPivLu().solve(sigma.reshaped<Eigen::RowMajor>());
  return found.reshaped<Eigen::RowMajor>(3, 3);
}

}  // namespace

TEST(PaperProjection, IsTheInPlanePartOfTheNineEquations) {
  constexpr double kModulus = 2.0, kRatio = 0.3;
  const PaperProjection law({kModulus, kRatio});
  const Lame lame = lame_constants({kModulus, kRatio});
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-0.4, 0.4);
  const auto vector = [&](double x, double y, double z) {
    return Vec3(x + any(random), y + any(random), z + any(random));
  };
  for (int trial = 0; trial < 200; ++trial) {
    const Mat3 rest = base(vector(1, 0, 0), vector(0, 1, 0)), now = base(vector(0, 0, 1.2), vector(1.1, 0, 0.1));
    // F takes tangents to tangents and normal to normal: the thickness is kept
    const Mat3 f = now * rest.inverse();
    const double j = f.determinant();
    ASSERT_GT(j, 0.0);
    const Mat3 sigma =
        (lame.mu * (f * f.transpose() - Mat3::Identity()) + lame.lambda * std::log(j) * Mat3::Identity()) / j;
    const Mat3 found = components_by_nine_equations(now, sigma);
    const Mat3 in_plane = now.leftCols<2>() * found.topLeftCorner<2, 2>() * now.leftCols<2>().transpose();  // eq. 13
    const Vec3 n = now.col(2);
    const Mat3 tangential = Mat3::Identity() - n * n.transpose();
    EXPECT_LT((in_plane - tangential * sigma * tangential).norm(), 1e-12 * sigma.norm()) << trial;
    // In coordinates that move with the surface, S^ab of the kernel is J sigma^ab.
    const Sym2<double> s = law.stress<double>(metric(now), metric(rest)).s;
    const double size = found.topLeftCorner<2, 2>().norm() * j + 1e-3 * kModulus;
    EXPECT_NEAR(s.c11, j * found(0, 0), 1e-12 * size) << trial;
    EXPECT_NEAR(s.c22, j * found(1, 1), 1e-12 * size) << trial;
    EXPECT_NEAR(s.c12, j * found(0, 1), 1e-12 * size) << trial;
    EXPECT_NEAR(found(0, 1), found(1, 0), 1e-12 * size) << trial;
  }
}
