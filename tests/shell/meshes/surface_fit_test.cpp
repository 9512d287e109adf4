// Splines through points.
#include "shell/meshes/surface_fit.h"

#include <gtest/gtest.h>

using namespace sunder;
using namespace sunder::shell;

namespace {

Vec3 quadratic(const Vec2& p) {
  return {p.x() + 0.1 * p.y(), p.y() - 0.05 * p.x() * p.y(), 0.2 * p.x() * p.x() - 0.3 * p.y() * p.y()};
}

std::vector<FitPoint> points_on(const std::function<Vec3(const Vec2&)>& f, double most) {
  std::vector<FitPoint> out;
  for (int i = 0; i <= 30; ++i)
    for (int j = 0; j <= 30; ++j) {
      const Vec2 p(i / 30.0, 0.7 * j / 30.0);
      if (p.norm() <= most) out.push_back({p, f(p), 1.0});
    }
  return out;
}

class SurfaceFitOfDegree : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Both, SurfaceFitOfDegree, testing::Values(2, 3));

// Third derivatives are what is kept small: a quadratic surface goes on beyond its points as it is.
TEST_P(SurfaceFitOfDegree, AQuadraticSurfaceIsExactAndGoesOnBeyondItsPoints) {
  const SurfaceFit fit = fit_surface(points_on(quadratic, 0.6), {1.0, 0.7}, {8, 6}, GetParam());
  for (const FitPoint& p : fit.points) EXPECT_LT((fit.patch.evaluate(p.at).x - p.x).norm(), 1e-9);
  const Vec2 corner(1.0, 0.7);
  EXPECT_LT((fit.patch.evaluate(corner).x - quadratic(corner)).norm(), 1e-5);  // kHeld draws what points do not hold
}

TEST_P(SurfaceFitOfDegree, ASphereIsFittedToThirdOrderAtLeast) {
  const auto dome = [](const Vec2& p) { return Vec3(p.x(), p.y(), std::sqrt(4.0 - p.squaredNorm())); };
  const auto error = [&](int n) {
    const SurfaceFit fit = fit_surface(points_on(dome, 2.0), {1.0, 0.7}, {n, n}, GetParam());
    double most = 0.0;
    for (const FitPoint& p : fit.points) most = std::max(most, std::abs(fit.patch.evaluate(p.at).x.norm() - 2.0));
    return most;
  };
  EXPECT_LT(error(12) / error(6), 1.0 / 6.0);  // 1/8 at third order
}

TEST(SurfaceFit, TheNearestPlaceIsWhereTheDistanceIsAcross) {
  const SurfaceFit fit = fit_surface(points_on(quadratic, 2.0), {1.0, 0.7}, {4, 4}, 2);
  const Vec2 at(0.4, 0.3);
  const SurfacePoint s = fit.patch.evaluate(at);
  const Vec3 x = s.x + 0.1 * s.u.cross(s.v).normalized();
  EXPECT_LT((nearest_place(fit.patch, x, {0.7, 0.6}) - at).norm(), 1e-9);
  // Beyond a corner it is the corner.
  EXPECT_LT((nearest_place(fit.patch, Vec3(5.0, 5.0, 0.0), {0.5, 0.5}) - Vec2(1.0, 0.7)).norm(), 1e-9);
}

}  // namespace
