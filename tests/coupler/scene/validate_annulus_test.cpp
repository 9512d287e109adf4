// Rings of a scene: refusals with field and remedy.
#include "tests/coupler/small_scene.h"

namespace {

using namespace small_scene;

std::string ring(const std::string& annulus, const std::string& more = "") {
  return replaced("plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }",
                  "annulus { " + annulus + " }\n" + more);
}

const std::string kRing = "inner_m: 0.1 outer_m: 0.3 element_m: 0.03";

}  // namespace

TEST(Annulus, IsAcceptedWithRimsAndLoads) {
  for (const std::string& text :
       {ring(kRing, "supports { edges: INNER kind: CLAMPED } supports { edges: OUTER kind: SIMPLY_SUPPORTED axes: Z }"),
        ring(kRing + " slit: true", "supports { edges: [U_MAX, ALL] kind: CLAMPED }"),
        ring(kRing + " angle_deg: 200 degree: 3", "loads { edge_force { edge: U_MIN force_per_length { z: 1 } } }"),
        ring(kRing, "loads { edge_moment { edge: OUTER moment_per_length: 1 } } loads { pressure: 3 }")})
    EXPECT_EQ(refusal(text).kind, "accepted") << refusal(text).what();
}

TEST(Annulus, OfAWrongSizeIsRefused) {
  const std::string f = "shells[0].annulus.";
  expect_refusal(ring("inner_m: 0 outer_m: 0.3 element_m: 0.05"), f + "inner_m", {"is 0", "a plate with a round trim"});
  expect_refusal(ring("outer_m: 0.3 element_m: 0.05"), f + "inner_m", {"missing"});
  expect_refusal(ring("inner_m: 0.4 outer_m: 0.3 element_m: 0.05"), f + "outer_m",
                 {"is 0.3 m, and inner_m is 0.4 m", "larger"});
  expect_refusal(ring("inner_m: 0.1 outer_m: 0.3 element_m: -1"), f + "element_m", {"-1"});
  expect_refusal(ring("inner_m: 0.1 outer_m: 0.3 element_m: 1e-6"), f + "element_m", {"more than 4096 elements"});
  expect_refusal(ring(kRing + " angle_deg: 400"), f + "angle_deg", {"is 400 degrees", "at most 360"});
  expect_refusal(ring(kRing + " slit: true angle_deg: 90"), f + "slit", {"angle_deg is 90"});
  expect_refusal(ring(kRing + " degree: 4"), f + "degree", {"is 4; 2 (quadratic) or 3"});
}

TEST(Annulus, WithoutTheEdgeIsRefused) {
  expect_refusal(ring(kRing, "supports { edges: U_MIN kind: CLAMPED }"), "shells[0].supports[0].edges",
                 {"has U_MIN, where the ring is closed", "`slit: true`"});
  expect_refusal(ring(kRing, "loads { edge_force { edge: U_MAX force_per_length { z: 1 } } }"),
                 "shells[0].loads[0].edge_force.edge", {"has U_MAX"});
  expect_refusal(replaced("elements_y: 16 }", "elements_y: 16 }\n  supports { edges: OUTER kind: CLAMPED }"),
                 "shells[0].supports[0].edges", {"has OUTER, a rim of an annulus; name ALL"});
}

TEST(Annulus, WithWhatIsForOnePatchIsRefused) {
  expect_refusal(ring(kRing, "supports { corners: U_MIN_V_MIN kind: SIMPLY_SUPPORTED }"), "shells[0].supports[0]",
                 {"a ring may be several", "boxes"});
  expect_refusal(ring(kRing, "loads { point { at { u: 0 v: 0 } force { z: 1 } } }"), "shells[0].loads[0].point",
                 {"a ring may be several", "edge_force or pressure"});
  const std::string law = "thickness_law { along: U points { factor: 1 } points { at_m: 1 factor: 0.5 } }";
  expect_refusal(ring(kRing, law), "shells[0].thickness_law.along", {"each sector", "take X, Y or Z", "at most 90"});
  EXPECT_EQ(refusal(ring(kRing + " angle_deg: 90", law)).kind, "accepted");
}

namespace {

std::string tube(const std::string& angle, const std::string& more = "") {
  return replaced(
      "plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }",
      "cylinder { radius_m: 0.1 length_m: 0.2 elements_u: 40 elements_v: 12 angle_deg: " + angle + " }\n" + more);
}

}  // namespace

TEST(WideArc, IsAcceptedUpToAWholeTurn) {
  for (const char* angle : {"149", "150", "359", "360"})
    EXPECT_EQ(refusal(tube(angle)).kind, "accepted") << refusal(tube(angle)).what();
  expect_refusal(tube("361"), "shells[0].cylinder.angle_deg", {"is 361", "at most 360"});
  expect_refusal(tube("0"), "shells[0].cylinder.angle_deg", {"is 0", "more than 0"});
}

TEST(WideArc, HasNoEndsWhereItIsClosedAndIsSeveralPatches) {
  const std::string held = "supports { edges: U_MAX kind: CLAMPED }";
  EXPECT_EQ(refusal(tube("300", held)).kind, "accepted");
  expect_refusal(tube("360", held), "shells[0].supports[0].edges", {"has U_MAX", "closed", "V_MIN or V_MAX"});
  expect_refusal(tube("300", "loads { point { at { u: 0 v: 0 } force { z: 1 } } }"), "shells[0].loads[0].point",
                 {"an arc so wide is several", "edge_force"});
  expect_refusal(tube("300", "supports { edges: INNER kind: CLAMPED }"), "shells[0].supports[0].edges",
                 {"a rim of an annulus"});
}

TEST(WideArc, OfAConeDoesNotEndInAPoint) {
  const auto cone = [](const std::string& more) {
    return replaced("plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }",
                    "cone { bottom_m: 0.1 height_m: 0.2 elements_u: 16 elements_v: 4 " + more + " }\n");
  };
  EXPECT_EQ(refusal(cone("angle_deg: 140")).kind, "accepted");
  EXPECT_EQ(refusal(cone("angle_deg: 360 top_m: 0.01")).kind, "accepted");
  expect_refusal(cone("angle_deg: 360"), "shells[0].cone.top_m", {"is 0", "small radius", "below 150"});
}
