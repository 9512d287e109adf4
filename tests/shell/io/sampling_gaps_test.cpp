// Warnings about bodies that sink between Gauss points.
#include <cmath>

#include <gtest/gtest.h>

#include "shell/io/sampling_gaps.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

ShellSetup sampled_sheet(int elements) {
  ShellSetup s{brittle_sheet(elements)};
  s.hertz = {0.0};
  return s;
}

RigidBody body(Shape shape) {
  RigidBody b;
  b.name = "stone", b.mass = 1.0, b.shape = std::move(shape);
  return b;
}

}  // namespace

// 20 elements of 10 mm with 2 x 2 points, 10/sqrt(3) mm apart at most: half of the diagonal of four.
TEST(FarthestFromSamples, IsHalfOfTheLargestDiagonal) {
  const double gap = 0.01 / std::sqrt(3.0);
  ShellModel coarse =
      make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {});
  EXPECT_NEAR(farthest_from_samples(coarse), gap / std::sqrt(2.0), 1e-9);
  ShellModel fine = make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 3, {});
  EXPECT_NEAR(farthest_from_samples(fine), 0.005 * std::sqrt(0.6) / std::sqrt(2.0), 1e-9);
}

TEST(HalfSides, AreThoseOfTheShapeInOrder) {
  EXPECT_EQ(half_sides(body(SphereShape{0.3})), Vec3::Constant(0.3));
  EXPECT_EQ(half_sides(body(BoxShape{Vec3(3, 1, 2)})), Vec3(1, 2, 3));
  const ConvexShape needle{{{Vec3(-1, 0, 0), Vec3(1, 0.02, 0), Vec3(1, 0, 0.04), Vec3(1, -0.02, 0)}}};
  EXPECT_TRUE(half_sides(body(needle)).isApprox(Vec3(0.02, 0.02, 1)));
  EXPECT_TRUE(std::isinf(half_sides(body(HalfSpaceShape{}))[0]));
}

TEST(SamplingGaps, TellsABallOfWhichMoreThanHalfAThicknessFitsBetweenPoints) {
  const ShellSetup shell = sampled_sheet(20);
  const double d = farthest_from_samples(shell.model), half = 0.5 * shell.model.thickness;
  const double just = (d * d + half * half) / (2.0 * half);  // r - sqrt(r^2 - d^2) = half
  EXPECT_EQ(sampling_gap_warning({shell}, {body(SphereShape{1.01 * just})}), "");
  const std::string told = sampling_gap_warning({shell}, {body(SphereShape{0.99 * just})});
  EXPECT_NE(told.find("ball 'stone' may sink 0.002 m into shell 'p' before it is felt"), std::string::npos) << told;
  // the remedies
  EXPECT_EQ(sampling_gap_warning({sampled_sheet(40)}, {body(SphereShape{0.99 * just})}), "");
  ShellSetup hertz = shell;
  hertz.hertz = {1e9};
  EXPECT_EQ(sampling_gap_warning({hertz}, {body(SphereShape{0.5 * just})}), "");
}

TEST(SamplingGaps, TellsSharpBodiesThatAreSmallAgainstTheDistance) {
  const ShellSetup shell = sampled_sheet(20);
  const double d = farthest_from_samples(shell.model);
  EXPECT_NE(sampling_gap_warning({shell}, {body(BoxShape{Vec3(1, 1, 1.9 * d)})}).find("an edge of 'stone' may sink"),
            std::string::npos);
  EXPECT_EQ(sampling_gap_warning({shell}, {body(BoxShape{Vec3(1, 1, 2.1 * d)})}), "");
  EXPECT_EQ(sampling_gap_warning({shell}, {body(HalfSpaceShape{})}), "");
}

TEST(SamplingGaps, LooksAtTheLeastThickness) {
  const auto said = [](double thickness, const ThicknessFactor& factor) {
    ShellSetup s{make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity()), thickness, glass(), 2, 2, {},
                            {}, {}, factor)};
    s.hertz = {0.0};
    return sampling_gap_warning({s}, {body(SphereShape{0.007})});  // sinks by 1.3 mm
  };
  EXPECT_EQ(said(0.004, {}), "");
  EXPECT_NE(said(0.002, {}), "");
  EXPECT_NE(said(0.004, [](const Patch&, const Vec2&) { return 0.5; }), "");
  EXPECT_EQ(said(0.002, [](const Patch&, const Vec2&) { return 2.0; }), "");
  EXPECT_NE(said(0.004, [](const Patch&, const Vec2& p) { return p.x() < 0.1 ? 1.0 : 0.5; }), "");
}
