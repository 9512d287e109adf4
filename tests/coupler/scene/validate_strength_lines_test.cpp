// Lines of strength, and seams with a strength: refusals, and the built model.
#include "tests/coupler/small_scene.h"

namespace {

using namespace small_scene;

}  // namespace

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
  refused(points + rest + "shells: \"pain\"", ".shells[0]", "is no shell of this scene");
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
