#include <cmath>
#include <numbers>
#include <utility>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/geometry/builders.h"
#include "shell/geometry/patch.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(Patch, DerivativesAreThoseOfItsPosition) {
  const Patch p = rational_patch();
  const double e = 1e-5;
  for (const Vec2& q : {Vec2(0.11, 0.7), Vec2(0.41, 0.21), Vec2(0.83, 0.55)}) {
    const auto at = [&](double du, double dv) { return p.evaluate(q + Vec2(du, dv)).x; };
    const SurfacePoint s = p.evaluate(q);
    // central differences: truncation O(e^2) = 1e-10 of third derivatives, round-off 1e-16 / e^2 = 1e-6
    EXPECT_LT((s.u - (at(e, 0) - at(-e, 0)) / (2 * e)).norm(), 1e-9);
    EXPECT_LT((s.motion.v - (at(0, e) - at(0, -e)) / (2 * e)).norm(), 1e-9);
    EXPECT_LT((s.uu - (at(e, 0) - 2 * s.motion.x + at(-e, 0)) / (e * e)).norm(), 2e-5);
    EXPECT_LT((s.vv - (at(0, e) - 2 * s.motion.x + at(0, -e)) / (e * e)).norm(), 2e-5);
    EXPECT_LT((s.uv - (at(e, e) - at(e, -e) - at(-e, e) + at(-e, -e)) / (4 * e * e)).norm(), 2e-5);
  }
}

TEST(Patch, OfAQuarterCylinderIsExact) {
  // rational quadratic arc with weights 1, sqrt(1/2), 1: a circle to round-off
  Patch p{KnotVector({0, 0, 0, 1, 1, 1}, 2, "u"), KnotVector({0, 0, 0, 1, 1, 1}, 2, "v"), {}, {}};
  for (const double z : {0.0, 0.5, 1.0})
    for (const auto& [x, y] : {std::pair{1.0, 0.0}, std::pair{1.0, 1.0}, std::pair{0.0, 1.0}}) {
      p.control_points.emplace_back(x, y, z);
      p.weights.push_back(x == y ? std::sqrt(0.5) : 1.0);
    }
  for (double u = 0.0; u <= 1.0; u += 0.125) EXPECT_NEAR(p.evaluate({u, 0.3}).x.head<2>().norm(), 1.0, 1e-15);
}

TEST(RefinedAtLeast, CutsLongSpansMoreOftenAndKeepsTheSurface) {
  const Patch p = rational_patch();  // spans of 0.3, 0.2 and 0.5; 0.4 and 0.6
  const Patch fine = refined_at_least(p, 5, 1);
  EXPECT_EQ(fine.knots_u.spans(), 2 + 1 + 3);
  EXPECT_EQ(fine.knots_v.spans(), 2);
  for (int s = 0; s < fine.knots_u.spans(); ++s) EXPECT_LE(fine.knots_u.span_length(s), 0.2 + 1e-15);
  for (const Vec2& q : {Vec2(0.11, 0.7), Vec2(0.41, 0.21), Vec2(0.83, 0.55)})
    EXPECT_LT((fine.evaluate(q).x - p.evaluate(q).x).norm(), 1e-15);  // lengths of 1: round-off
  EXPECT_EQ(refined_at_least(plate(1, 1, 3, 1, Vec3::Zero(), Quat::Identity()), 3, 4).columns(), 3 + 2);
  EXPECT_THROW(refined_at_least(p, 0, 1), Error);
}

TEST(CubicPatch, DerivativesAreThoseOfItsPosition) {
  const Patch p = cubic_patch();
  const double e = 1e-5;
  for (const Vec2& q : {Vec2(0.11, 0.7), Vec2(0.41, 0.21), Vec2(0.83, 0.55)}) {
    const auto at = [&](double du, double dv) { return p.evaluate(q + Vec2(du, dv)).x; };
    const SurfacePoint s = p.evaluate(q);
    // as for quadratic patches: truncation 1e-10 of third derivatives, round-off 1e-16 / e^2 = 1e-6
    EXPECT_LT((s.u - (at(e, 0) - at(-e, 0)) / (2 * e)).norm(), 1e-8);
    EXPECT_LT((s.motion.v - (at(0, e) - at(0, -e)) / (2 * e)).norm(), 1e-8);
    EXPECT_LT((s.uu - (at(e, 0) - 2 * s.motion.x + at(-e, 0)) / (e * e)).norm(), 2e-5);
    EXPECT_LT((s.vv - (at(0, e) - 2 * s.motion.x + at(0, -e)) / (e * e)).norm(), 2e-5);
    EXPECT_LT((s.uv - (at(e, e) - at(e, -e) - at(-e, e) + at(-e, -e)) / (4 * e * e)).norm(), 2e-5);
  }
}

TEST(CubicPatch, ElevatedIsTheSameSurface) {
  const Patch quadratic = revolved({Vec2(1.0, 0.0), Vec2(0.9, 0.7), Vec2(0.3, 1.0)}, {1.0, 0.8, 1.3}, 1.7);
  const Patch cubic = elevated(quadratic), fine = refined(cubic, 5, 3);
  EXPECT_EQ(cubic.degree(), 3);
  EXPECT_EQ(fine.columns(), 8);
  EXPECT_EQ(fine.rows(), 6);
  for (double u = 0.0; u <= 1.0; u += 0.125)
    for (double v = 0.0; v <= 1.0; v += 0.125) {
      const SurfacePoint a = quadratic.evaluate({u, v});
      for (const Patch* p : {&cubic, &fine}) {
        const SurfacePoint b = p->evaluate({u, v});
        EXPECT_LT((a.x - b.x).norm(), 1e-14);
        EXPECT_LT((a.u - b.u).norm() + (a.v - b.v).norm(), 1e-13);
        EXPECT_LT((a.uu - b.uu).norm() + (a.uv - b.uv).norm() + (a.vv - b.vv).norm(), 1e-11);
      }
    }
  EXPECT_THROW(elevated(cubic), Error);
  EXPECT_THROW(elevated(refined(quadratic, 2, 1)), Error);
  EXPECT_THROW(cylinder(1.0, 1.0, 1.0, 4, 4, 4), Error);
}

TEST(CubicPatch, SectorsAreExact) {
  const Patch c = cylinder(2.0, 3.0, 1.2, 5, 3, 3), s = sphere(2.0, 1.1, -0.4, 0.5 * std::numbers::pi, 4, 6, 3),
              k = cone(2.0, 0.5, 3.0, 0.9, 3, 2, 3);
  for (double u = 0.0; u <= 1.0; u += 0.1)
    for (double v = 0.0; v <= 1.0; v += 0.1) {
      const Vec3 d = k.evaluate({u, v}).x;
      EXPECT_NEAR(c.evaluate({u, v}).x.head<2>().norm(), 2.0, 1e-14);
      EXPECT_NEAR(s.evaluate({u, v}).x.norm(), 2.0, 1e-14);
      EXPECT_NEAR(d.head<2>().norm(), 2.0 - 0.5 * d.z(), 1e-14);
    }
}
