// Patches of common shape.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/geometry/builders.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kPi = std::numbers::pi;

}  // namespace

TEST(Builders, SurfacesOfRevolutionAreExact) {
  const Patch c = cylinder(2.0, 3.0, 1.2, 5, 3), s = sphere(2.0, 1.1, -0.4, 0.5 * kPi, 4, 6),
              k = cone(2.0, 0.5, 3.0, 0.9, 3, 2);
  EXPECT_EQ(c.columns(), 7);
  EXPECT_EQ(c.rows(), 5);
  for (double u = 0.0; u <= 1.0; u += 0.1)
    for (double v = 0.0; v <= 1.0; v += 0.1) {
      const Vec3 a = c.evaluate({u, v}).x, b = s.evaluate({u, v}).x, d = k.evaluate({u, v}).x;
      EXPECT_NEAR(a.head<2>().norm(), 2.0, 1e-14);
      EXPECT_LE(std::abs(std::atan2(a.y(), a.x())), 0.6 + 1e-14);
      EXPECT_NEAR(b.norm(), 2.0, 1e-14);
      EXPECT_NEAR(d.head<2>().norm(), 2.0 - 0.5 * d.z(), 1e-14);
    }
  EXPECT_NEAR(s.evaluate({0.3, 1.0}).x.z(), 2.0, 1e-14);  // the pole
  EXPECT_THROW(cylinder(1.0, 1.0, 3.0, 4, 4), Error);
  EXPECT_THROW(sphere(1.0, 1.0, 0.3, 0.2, 4, 4), Error);
}

TEST(Builders, RefinementLeavesARationalSurfaceAsItIs) {
  const Patch coarse = sphere(1.0, 1.0, 0.0, 1.2, 1, 1), fine = refined(coarse, 7, 3);
  for (double u = 0.03; u < 1.0; u += 0.19)
    for (double v = 0.01; v < 1.0; v += 0.17) {
      const SurfacePoint a = coarse.evaluate({u, v}), b = fine.evaluate({u, v});
      EXPECT_LT((a.x - b.x).norm(), 1e-14);
      EXPECT_LT((a.uv - b.uv).norm(), 1e-12);
      EXPECT_LT((a.vv - b.vv).norm(), 1e-12);
    }
  EXPECT_THROW(refined(fine, 8, 3), Error);  // no multiple of 7
}
