#include <cstdio>
#include <numbers>

#include <gtest/gtest.h>

#include "shell/geometry/builders.h"
#include "shell/geometry/parameter_place.h"

using namespace sunder;
using namespace sunder::shell;

// The last knot of this plate is 1.1 but for round-off.
TEST(ParameterPlace, ByAnEdgeIsOnIt) {
  const Patch p = with_parameters_as_lengths(plate(1.1, 0.3, 24, 40, Vec3::Zero(), Quat::Identity()));
  const Vec2 corner(p.knots_u.end(), p.knots_v.end());
  EXPECT_EQ(moved_onto_edges(p, {1.1, 0.3}), corner);
  EXPECT_EQ(moved_onto_edges(p, {1.1 + 1e-6, 0.3 - 1e-6}), corner);
  EXPECT_EQ(moved_onto_edges(p, {-1e-6, 0.1}), Vec2(0.0, 0.1));
  const Vec2 outside(1.1 + 1e-5, 0.1);
  EXPECT_EQ(moved_onto_edges(p, outside), outside);
  EXPECT_FALSE(p.contains(outside));
}

// The length of an arc is irrational: what the range prints has to be a place on the patch.
TEST(ParameterPlace, AtThePrintedEndsIsOnThePatch) {
  const Patch p = with_parameters_as_lengths(cylinder(4.953, 5.175, 0.5 * 3.14159265358979, 24, 24));
  double u0 = -1, u1 = -1, v0 = -1, v1 = -1;
  ASSERT_EQ(std::sscanf(parameter_range(p).c_str(), "from %lf to %lf along u and from %lf to %lf along v", &u0, &u1,
                        &v0, &v1),
            4)
      << parameter_range(p);
  EXPECT_EQ(moved_onto_edges(p, {u1, v1}), Vec2(p.knots_u.end(), p.knots_v.end()));
  EXPECT_EQ(moved_onto_edges(p, {u0, v0}), Vec2(p.knots_u.begin(), p.knots_v.begin()));
}

// The end of a quarter of a circle is at a place that its scene gives, however many elements there are.
TEST(ParameterPlace, AtTheEndOfAnArcIsOnTheEdgeForAnyDivision) {
  const double radius = 4.953, length = 5.175, arc = radius * std::numbers::pi / 2.0;
  for (const int elements : {1, 2, 3, 5, 8, 24}) {
    const Patch p = with_parameters_as_lengths(cylinder(radius, length, 0.5 * std::numbers::pi, elements, elements, 3));
    const Vec2 corner(p.knots_u.end(), p.knots_v.end());
    EXPECT_EQ(moved_onto_edges(p, {arc, length}), corner) << elements << ": " << parameter_range(p);
    const Vec2 outside(arc + 1e-3 * arc / elements, length);
    EXPECT_FALSE(p.contains(moved_onto_edges(p, outside))) << elements;
  }
}
