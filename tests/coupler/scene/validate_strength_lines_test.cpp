// Lines of strength, and seams with a strength: refusals, and the built model.
#include <cmath>
#include <map>

#include "tests/coupler/small_scene.h"

namespace {

using namespace small_scene;
using sunder::Vec2;
using sunder::Vec3;

/// Number of Gauss points of a shell with each factor of strength, which must be one of those given.
std::map<double, int> points_of(const sunder::shell::ShellModel& m) {
  std::map<double, int> out;
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int e = 0; e < m.tables.spans_u; ++e) ++out[m.strength_factor_at(q, e)];
  return out;
}

}  // namespace

TEST(StrengthLines, WeakenWhatIsWithinHalfTheirWidth) {
  const auto setup = built(
      strong("strength_lines { points { u: 0.1 v: 0 } points { u: 0.1 v: 0.3 } points { u: 0.4 v: 0.3 } width_m: 0.08 "
             "factor: 0.25 } strength_regions { low {} high { u: 0.1 v: 0.5 } factor: 2 }"));
  const auto& m = setup.shells[0].model;
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int e = 0; e < m.tables.spans_u; ++e) {
      const Vec2 p = gauss_point(m.patch, m.tables, q, e).parameter;
      const Vec2 corner(0.1, 0.3);
      const double to_first = std::hypot(p.x() - 0.1, std::max(0.0, p.y() - 0.3)),
                   to_second = std::hypot(std::max({0.1 - p.x(), 0.0, p.x() - 0.4}), p.y() - 0.3);
      const bool near = std::min(to_first, to_second) <= 0.04;
      EXPECT_EQ(m.strength_factor_at(q, e), (near ? 0.25 : 1.0) * (p.x() <= 0.1 ? 2.0 : 1.0));
    }
  EXPECT_EQ(points_of(m).size(), 4u);
}

// A line in space runs over both shells, and leaves out one that it does not name.
TEST(StrengthLines, InSpaceRunOverShells) {
  const std::string line =
      "strength_lines { points { x: -0.2 y: 0.05 } points { x: 0.7 y: 0.05 } width_m: 0.04 factor: 0.5 ";
  const auto both = built(strong("", kWing + line + "}\n"));
  for (const auto& s : both.shells) {
    auto points = points_of(s.model);
    EXPECT_GT(points[0.5], 0) << s.model.name;
    EXPECT_EQ(points.size(), 2u) << s.model.name;
  }
  EXPECT_EQ(both.shells[0].model.strength_factor_at(0, 0), 1.0);
  const auto one = built(strong("", kWing + line + "shells: \"wing\" }\n"));
  EXPECT_TRUE(one.shells[0].model.strength_factor.empty());
  EXPECT_EQ(points_of(one.shells[1].model).size(), 2u);
}

// The chord of an arc lies below it; the line weakens the arc all the same, and not what lies opposite.
TEST(StrengthLines, InSpaceFollowACurvedShell) {
  const std::string shell =
      "name: \"vault\" material: \"glass\" thickness_m: 0.01 cylinder { radius_m: 1 length_m: 1 angle_deg: 120 "
      "elements_u: 96 elements_v: 48 }";
  const auto setup =
      built(strong("", "shells { " + shell +
                           " }\nstrength_lines { shells: \"vault\" width_m: 0.1 factor: 0.5 "
                           "points { x: 0.5 y: -0.8660254 z: 0.5 } points { x: 0.5 y: 0.8660254 z: 0.5 } }\n"));
  const auto& m = setup.shells[1].model;
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int e = 0; e < m.tables.spans_u; ++e) {
      const Vec3 x = m.patch.evaluate(gauss_point(m.patch, m.tables, q, e).parameter).x;
      EXPECT_EQ(m.strength_factor_at(q, e), std::abs(x.z() - 0.5) <= 0.05 ? 0.5 : 1.0) << x.transpose();
    }
}

TEST(StrengthLines, AreRefusedWherePlaceOrFactorIsWrong) {
  const std::string points = "points { u: 0.1 v: 0.1 } points { u: 0.4 v: 0.1 } ";
  const auto refused = [](const std::string& line, const std::string& field, const std::string& says) {
    expect_refusal(strong("strength_lines { " + line + " }"), "shells[0].strength_lines[0]" + field, {says});
  };
  refused("points { u: 0.1 } width_m: 0.1 factor: 0.5", ".points", "two or more");
  refused("points { u: nan } points {} width_m: 0.1 factor: 0.5", ".points[0]", "must be finite");
  refused("points { u: 0.1 } points { u: 0.1 } width_m: 0.1 factor: 0.5", ".points[1]", "leave one of them out");
  refused(points + "factor: 0.5", ".width_m", "is missing");
  refused(points + "width_m: -1 factor: 0.5", ".width_m", "must be positive");
  refused(points + "width_m: 0.1", ".factor", "is missing");
  refused(points + "width_m: 0.1 factor: 0", ".factor", "must be positive");
  refused(points + "width_m: 0.01 factor: 0.5", ".width_m", "would have gaps; give 0.03128 m or more");
  EXPECT_EQ(refusal(strong("strength_lines { " + points + "width_m: 0.03128 factor: 0.5 }")).kind, "accepted");
  refused("points { u: 1 } points { u: 2 } width_m: 0.1 factor: 0.5", "", "passes no Gauss point");
  expect_refusal(strong("strength_lines { " + points + "width_m: 0.1 factor: 0.5 }", "", ""),
                 "shells[0].strength_lines", {"'glass' has not"});
}

TEST(StrengthLines, InSpaceAreRefusedWherePlaceOrShellIsWrong) {
  const std::string points = "points { x: -0.2 } points { x: 0.2 } ", rest = "width_m: 0.1 factor: 0.5 ";
  const auto refused = [](const std::string& line, const std::string& field, const std::string& says) {
    expect_refusal(strong("", "strength_lines { " + line + " }\n"), "strength_lines[0]" + field, {says});
  };
  refused("points { x: 1 }" + rest, ".points", "two or more");
  refused("points { x: 1 } points { x: inf }" + rest, ".points[1]", "must be finite");
  refused(points + "factor: 0.5", ".width_m", "is missing");
  refused(points + "width_m: 0.1 factor: 1e7", ".factor", "1e-06 to 1e+06");
  refused(points + "width_m: 0.01 factor: 0.5", ".width_m", "longest element of shell 'pane'");
  refused(points + rest + "shells: \"pain\"", ".shells[0]", "is no shell of this scene");
  refused("points { z: 3 } points { x: 0.2 z: 3 } " + rest, "", "passes no Gauss point of a shell");
  expect_refusal(strong("", "strength_lines { " + points + rest + " }\n", ""), "strength_lines[0]",
                 {"no shell has a material with a strength"});
  expect_refusal(strong("", "strength_lines { " + points + rest + " shells: \"pane\" }\n", ""),
                 "strength_lines[0].shells[0]", {"'glass' has no strength"});
}

TEST(SeamStrengths, AreBuiltOrRefused) {
  const auto with = [](const std::string& rule, const std::string& more = "") {
    return strong("", kWing + "seams { rules { first: \"pane\" second: \"wing\" " + rule + " } }\n" + more);
  };
  const auto setup = built(with("strength: 2e4"));
  ASSERT_EQ(setup.stitches.seams.size(), 1u);
  EXPECT_EQ(setup.stitches.seams[0].strength, 2e4);
  EXPECT_TRUE(setup.shells[0].can_crack());  // its seam may part
  expect_refusal(with("strength: 0"), "seams.rules[0].strength", {"must be positive"});
  expect_refusal(with("strength: nan"), "seams.rules[0].strength", {"must be positive and finite"});
  expect_refusal(with("kind: OPEN strength: 1"), "seams.rules[0].strength", {"kind is OPEN", "leave one of them out"});
  expect_refusal(with("strength: 1", "coupling { scheme: ITERATED }\n"), "seams.rules[0].strength",
                 {"a pass that is repeated", "PROXY or EXPORTED"});
}
