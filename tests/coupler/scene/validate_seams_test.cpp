// Seams of a scene: refusals with field and remedy.
#include "tests/shell/io/two_plates.h"

namespace {

using namespace small_scene;

}  // namespace

TEST(SceneSeams, AreAcceptedWithEveryRule) {
  for (const char* rules : {"", "rules { first: \"pane\" second: \"wing\" kind: HINGE }",
                            "tolerance_m: 1e-5 rules { first: \"wing\" second: \"pane\" kind: OPEN }"}) {
    const sunder::Error e = refusal(two_plates(fmt::format("seams {{ {} }}", rules)));
    EXPECT_EQ(e.kind, "accepted") << e.what();
  }
}

TEST(SceneSeams, OfUnknownShellsAreRefused) {
  expect_refusal(two_plates("seams { rules { first: \"pane\" second: \"wnig\" kind: HINGE } }"),
                 "seams.rules[0].second", {"'wnig' is no shell of this scene"});
  expect_refusal(two_plates("seams { rules { first: \"pane\" second: \"pane\" kind: HINGE } }"),
                 "seams.rules[0].second", {"a seam is between two shells"});
  expect_refusal(
      two_plates("seams { rules { first: \"pane\" second: \"wing\" } rules { first: \"wing\" second: \"pane\" } }"),
      "seams.rules[1]", {"says again"});
}

TEST(SceneSeams, OfAToleranceOutOfRangeAreRefused) {
  for (const char* value : {"0", "-1e-6", "2", "nan"})
    expect_refusal(two_plates(fmt::format("seams {{ tolerance_m: {} }}", value)), "seams.tolerance_m",
                   {"above 0, at most 1"});
}

TEST(SceneSeams, WithFieldsForSingleShellsAreRefused) {
  expect_refusal(two_plates("seams {}", "equilibrium {}"), "shells[1].equilibrium",
                 {"is given, and shell 'pane', which a seam joins to 'wing', has none; give it to both"});
  const char* grown = "loads { pressure: -10 factor { time_s: 0 value: 0 } factor { time_s: 0.1 value: 1 } }";
  EXPECT_EQ(refusal(two_plates("seams {}", grown, 0.5)).kind, "accepted");
  expect_refusal(two_plates("seams {} transfer { kind: FLIP }"), "transfer", {"cannot go with seams", "move together"});
}

// A cut on a seam opens it. A cut on a clamped edge runs just inside. The other three sides of the rectangle are one
// line.
TEST(SceneCuts, OnEdgesOfThePatchOpenSeamsAndSupports) {
  const std::string rectangle =
      "cuts { points { u: 0 v: 0.1 } points { u: 0 v: 0.4 } points { u: 0.2 v: 0.4 } points { u: 0.2 v: 0.1 } "
      "points { u: 0 v: 0.1 } }";
  const auto cut = [&](const std::string& seams, const std::string& more) {
    const std::string path = own_file("edge_cut_scene.textproto");
    std::ofstream(path) << two_plates(seams, rectangle + more);
    const auto setup = sunder::shell::build(sunder::scene::load(path, {}));
    std::remove(path.c_str());
    // the other shell gets a free edge, and its stable step accounts for it
    EXPECT_EQ(setup.shells[0].can_crack(), !seams.empty());
    return setup.shells[1].fracture.cuts.at(0);
  };
  const auto opened = cut("seams {}", "");
  ASSERT_EQ(opened.on_edges.size(), 1u);
  EXPECT_EQ(opened.on_edges[0].edge, sunder::shell::kUMin);
  EXPECT_DOUBLE_EQ(opened.on_edges[0].from, 0.2);
  EXPECT_DOUBLE_EQ(opened.on_edges[0].to, 0.8);
  ASSERT_EQ(opened.lines.size(), 1u);
  EXPECT_EQ(opened.lines[0].size(), 4u);
  EXPECT_EQ(opened.lines[0].front(), sunder::Vec2(0.0, 0.4));
  EXPECT_EQ(opened.lines[0].back(), sunder::Vec2(0.0, 0.1));
  const auto parted = cut("", " supports { edges: U_MIN kind: CLAMPED }");
  EXPECT_TRUE(parted.on_edges.empty());
  ASSERT_EQ(parted.lines.size(), 2u);
  for (const sunder::Vec2& p : parted.lines[1]) EXPECT_NEAR(p.x(), 5e-4 * 0.5 / 16, 1e-12);
  for (const char* seams : {"", "seams { rules { first: \"pane\" second: \"wing\" kind: OPEN } }"})
    expect_refusal(two_plates(seams, rectangle), "shells[1].cuts[0]",
                   {"from (0, 0.1) to (0, 0.4), on which nothing hangs", "leave that side out"});
  expect_refusal(two_plates("", rectangle + " supports { edges: U_MIN kind: SIMPLY_SUPPORTED }"), "shells[1].cuts[0]",
                 {"a support holds without its slope", "leave the support out"});
}
