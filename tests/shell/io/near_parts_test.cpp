// Parts of one file that are nearer than their thickness.
#include "shell/io/near_parts.h"

#include <cmath>

#include "tests/shell/io/mesh_scene.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

class NearPartsOfAFile : public MeshScene {};

constexpr double kPartThickness = 0.01;  // of MeshScene [m]

// A rectangle and a smaller one above it, `apart` [m], tilted so that only one corner is that near.
std::string plates(double apart, double tilt = 0.0) {
  std::string out = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  for (const Vec2& x : {Vec2(0.3, 0.3), Vec2(0.7, 0.3), Vec2(0.7, 0.7), Vec2(0.3, 0.7)})
    out += fmt::format("v {} {} {}\n", x.x(), x.y(), apart + tilt * (x.x() + x.y() - 0.6));
  return out + "f 1 2 3\nf 1 3 4\nf 5 6 7\nf 5 7 8\n";
}

TEST_F(NearPartsOfAFile, NearerThanTheirThicknessIsToldWithPlaceAndRemedy) {
  write("a.obj", plates(0.004, 0.01));  // the corner at (0.3, 0.3) is nearest
  const RunSetup r = setup("path: 'a.obj' element_m: 0.1");
  const std::vector<NearParts> near = near_parts(r);
  ASSERT_EQ(near.size(), 1u);
  // The nearest Gauss point is within an element of the corner.
  EXPECT_GE(near[0].apart, 0.004 / std::sqrt(1.0 + 2 * 0.01 * 0.01) - 1e-9);  // along the tilted normal
  EXPECT_LT(near[0].apart, 0.004 + 0.01 * 0.2);
  EXPECT_NEAR(near[0].thickness, kPartThickness, 1e-15);
  EXPECT_LT((near[0].at.head<2>() - Vec2(0.3, 0.3)).norm(), 0.15);
  ASSERT_EQ(r.touching.size(), 1u);
  expect_part(r.touching[0], "shells 'pane.1' and 'pane.2' are 0.004");
  expect_part(r.touching[0], "less than their thickness of 0.01 m, and no seam joins them");
  expect_part(r.touching[0], fmt::format("give a thickness of at most {:.3g} m", 0.9 * near[0].apart));
}

TEST_F(NearPartsOfAFile, TheRemedyIsOne) {
  write("a.obj", plates(0.004));
  const double thinner = free_thickness(setup("path: 'a.obj' element_m: 0.1"), kPartThickness);
  EXPECT_NEAR(thinner, 0.9 * 0.004, 1e-9);
  RunSetup r = setup("path: 'a.obj' element_m: 0.1");
  for (ShellSetup& s : r.shells) s.model.thickness = thinner;
  EXPECT_TRUE(near_parts(r).empty());
}

TEST_F(NearPartsOfAFile, WhatHasRoomIsNotNamed) {
  write("a.obj", plates(0.0101));
  const RunSetup r = setup("path: 'a.obj' element_m: 0.1");
  EXPECT_EQ(r.shells.size(), 2u);
  EXPECT_TRUE(r.touching.empty());
  EXPECT_EQ(free_thickness(r, kPartThickness), kPartThickness);
}

TEST_F(NearPartsOfAFile, PartsThatTouchHaveNoThicknessThatHelps) {
  write("a.obj", plates(1e-5));
  const RunSetup r = setup("path: 'a.obj' element_m: 0.1");
  EXPECT_EQ(free_thickness(r, kPartThickness), kPartThickness);
  ASSERT_EQ(r.touching.size(), 1u);
  expect_part(r.touching[0], "contact parts them from the start; leave one of them out");
}

TEST_F(NearPartsOfAFile, JoinedPartsAreOneSurface) {
  write("a.obj", ball(0.005, 4));  // as thick as it is wide
  const RunSetup r = setup("path: 'a.obj' element_m: 0.002");
  EXPECT_GT(r.shells.size(), 1u);
  EXPECT_TRUE(near_parts(r).empty());
}

}  // namespace
