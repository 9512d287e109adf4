// The signed distance to a solid that is not convex.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "coupler/scene/mesh.h"
#include "shell/contact/proxy.h"
#include "tests/coupler/arch.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

Surface surface_of(const arch::Mesh& m) {
  std::vector<scene::Polygon> polygons;
  for (const auto& face : m.faces) polygons.push_back({face, 0});
  return scene::closed_surface(m.points, polygons);
}

// Of the arch, without triangles: it is three boxes, and its faces are rectangles along the axes.
double arch_distance(const Vec3& x) {
  using namespace arch;
  const auto to_box = [&](const Vec3& low, const Vec3& high) {
    return (low - x).cwiseMax(x - high).cwiseMax(0.0).norm();
  };
  const double left = to_box({0, 0, 0}, {kLeft, kDeep, kHigh}), right = to_box({kRight, 0, 0}, {kWide, kDeep, kHigh}),
               top = to_box({0, 0, kGapHigh}, {kWide, kDeep, kHigh});
  const double outside = std::min({left, right, top});
  if (outside > 0.0) return outside;
  double in = std::min({x.y(), kDeep - x.y(), x.x(), kWide - x.x(), kHigh - x.z()});  // to the sides of the whole
  in = std::min(in, to_box({kLeft, 0, 0}, {kRight, kDeep, kGapHigh}));                // to the gap
  in = std::min(in, std::min(to_box({0, 0, -1}, {kLeft, kDeep, 0}),
                             to_box({kRight, 0, -1}, {kWide, kDeep, 0})));  // below the feet
  return -in;
}

Vec3 anywhere(std::mt19937& random, const Vec3& low, const Vec3& high) {
  Vec3 x;
  for (int d = 0; d < 3; ++d) x[d] = std::uniform_real_distribution(low[d], high[d])(random);
  return x;
}

TEST(SolidDistance, IsThatOfTheArchEverywhere) {
  const SolidDistance solid(surface_of(arch::mesh()));
  std::mt19937 random(1);
  int inside = 0, in_gap = 0;
  for (int k = 0; k < 20000; ++k) {
    const Vec3 x = anywhere(random, {-0.02, -0.02, -0.02}, {0.08, 0.05, 0.07});
    const double expected = arch_distance(x);
    ASSERT_NEAR(solid.at(x).value, expected, 1e-15) << x.transpose();
    inside += expected < 0.0;
    in_gap += x.x() > arch::kLeft && x.x() < arch::kRight && x.z() > 0.0 && x.z() < arch::kGapHigh && expected > 0.0;
  }
  EXPECT_GT(inside, 1000);
  EXPECT_GT(in_gap, 300);
}

TEST(SolidDistance, GrowsAlongItsNormal) {
  const SolidDistance solid(surface_of(arch::mesh()));
  std::mt19937 random(2);
  constexpr double kStep = 1e-7;  // central differences: round-off of 1e-17 over it
  int smooth = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vec3 x = anywhere(random, {-0.02, -0.02, -0.02}, {0.08, 0.05, 0.07});
    const SolidDistance::Found found = solid.at(x);
    EXPECT_NEAR(found.normal.norm(), 1.0, 1e-14);
    Vec3 gradient;
    for (int d = 0; d < 3; ++d)
      gradient[d] =
          (solid.at(x + kStep * Vec3::Unit(d)).value - solid.at(x - kStep * Vec3::Unit(d)).value) / (2 * kStep);
    if (std::abs(gradient.norm() - 1.0) > 1e-3) continue;  // as far from two faces: there is a kink
    ++smooth;
    EXPECT_NEAR((gradient - found.normal).norm(), 0.0, 1e-4) << x.transpose();  // curvature: step over distance
  }
  EXPECT_GT(smooth, 1900);
}

TEST(SolidDistance, IsTheSameWhateverIsGuessed) {
  const Surface surface = surface_of(arch::mesh());
  const SolidDistance solid(surface);
  std::mt19937 random(4);
  const int last = static_cast<int>(surface.triangles.size()) - 1;
  for (int k = 0; k < 2000; ++k) {
    const Vec3 x = anywhere(random, {-0.02, -0.02, -0.02}, {0.08, 0.05, 0.07});
    const SolidDistance::Found found = solid.at(x);
    const int guess = std::uniform_int_distribution(0, last)(random);
    const SolidDistance::Found guessed = solid.at(x, guess);
    EXPECT_EQ(guessed.value, found.value) << x.transpose();
    EXPECT_LT((guessed.normal - found.normal).norm(), 1e-12) << x.transpose();
    EXPECT_LT((guessed.point - found.point).norm(), 1e-12) << x.transpose();
    EXPECT_NEAR((x - found.point).norm(), std::abs(found.value), 1e-15);
  }
}

TEST(SolidDistance, HasTheSignOfTheWindingNumberBesideSharpEdges) {
  // a star of eight thin rays, each of them sharper than a right angle: where a nearest face's plane tells nothing
  std::vector<std::array<double, 2>> star;
  for (int i = 0; i < 16; ++i) {
    const double r = i % 2 ? 0.2 : 1.0, angle = -2.0 * M_PI * i / 16;
    star.push_back({r * std::cos(angle), r * std::sin(angle)});
  }
  const Surface s = surface_of(arch::prism(star, 0.3));
  const SolidDistance solid(s);
  std::mt19937 random(3);
  for (int k = 0; k < 5000; ++k) {
    const Vec3 x = anywhere(random, {-1.2, -0.2, -1.2}, {1.2, 0.5, 1.2});
    EXPECT_EQ(solid.at(x).value<0.0, scene::winding_number(s, x)> 0.5) << x.transpose();
  }
}

TEST(SolidDistance, OfAProxyMovesWithItAndLeavesHullsAlone) {
  RigidBody body;
  body.motion.position = {1, 2, 3};
  body.motion.orientation = Quat(Eigen::AngleAxisd(0.8, Vec3(3, -1, 2).normalized()));
  ConvexShape shape;
  shape.parts = scene::convex_parts(surface_of(arch::mesh()));
  body.shape = shape;
  const Proxy parts(body);  // without the surface: planes of each part
  shape.surface = std::make_shared<Surface>(surface_of(arch::mesh()));
  body.shape = shape;
  const Proxy solid(body);
  EXPECT_EQ(solid.radius(), parts.radius());
  EXPECT_EQ(parts.half_width(), parts.radius());
  EXPECT_NEAR(solid.half_width(), 0.5 * arch::kHigh, 1e-15);
  const auto at = [&](const Vec3& local) -> Vec3 { return body.motion.position + body.motion.orientation * local; };
  // behind a wall between two parts: the planes say 0 there, and the surface is far away
  const Vec3 corner(0.02, 0.015, 0.04);
  EXPECT_NEAR(solid.distance(at(corner)).value, arch_distance(corner), 1e-14);
  EXPECT_GT(parts.distance(at(corner)).value, -0.011);
  const Vec3 gap(0.039, 0.015, 0.01);
  EXPECT_NEAR(solid.distance(at(gap)).value, 0.001, 1e-14);
  EXPECT_NEAR((solid.distance(at(gap)).normal - body.motion.orientation * Vec3(-1, 0, 0)).norm(), 0.0, 1e-12);
}

}  // namespace
