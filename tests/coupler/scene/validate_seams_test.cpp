// Seams of a scene: refusals with field and remedy.
#include "tests/coupler/small_scene.h"

namespace {

using namespace small_scene;

// Two plates side by side, additional fields of the second one, and seams.
std::string two_plates(const std::string& seams, const std::string& shell = "", double x = 0.5) {
  std::string text = replaced("bodies {", "# bodies: none\nbodies {");
  text.resize(text.find("# bodies"));
  return text + fmt::format(R"(shells {{
  name: "wing"
  material: "glass"
  thickness_m: 0.004
  plate {{ size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 pose {{ position {{ x: {} }} }} }}
  {}
}}
{}
)",
                            x, shell, seams);
}

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

TEST(SceneSeams, WithoutACommonEdgeAreRefused) {
  const std::string fastened = "seams { rules { first: \"pane\" second: \"wing\" } }";
  EXPECT_EQ(refusal(two_plates(fastened)).kind, "accepted");
  expect_refusal(two_plates(fastened, "", 1.5), "seams.rules[0]", {"'pane' and 'wing'", "no whole edge in common"});
  EXPECT_EQ(refusal(two_plates("seams { rules { first: \"pane\" second: \"wing\" kind: OPEN } }", "", 1.5)).kind,
            "accepted");
}

TEST(SceneSeams, WithASupportThatWouldDoNothingAreRefused) {
  const auto with = [](const std::string& pane, const std::string& wing, const std::string& rule) {
    std::string text = two_plates("seams { " + rule + " }", wing);
    return text.insert(text.find("shells {") + 8, pane);
  };
  const std::string hinge = "rules { first: \"pane\" second: \"wing\" kind: HINGE }";
  const std::string left = " supports { edges: U_MAX kind: SIMPLY_SUPPORTED axes: Z }";
  const std::string right = " supports { edges: U_MIN kind: SIMPLY_SUPPORTED axes: Z }";
  const std::vector<std::string> words{"along the axis Z, where they depend on others that are free", "kind HINGE"};
  expect_refusal(with("", right, ""), "shells[1].supports", words);
  expect_refusal(with(left, right, ""), "shells[0].supports", words);
  for (const std::string& scene :
       {with(left, right, hinge),
        with(" supports { edges: U_MAX kind: CLAMPED }", " supports { edges: U_MIN kind: CLAMPED }", ""),
        with("", " supports { edges: V_MIN kind: SIMPLY_SUPPORTED axes: Z }", "")})
    EXPECT_EQ(refusal(scene).kind, "accepted") << refusal(scene).what();
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
  expect_refusal(two_plates("seams {} transfer { kind: FLIP }"), "transfer", {"cannot go with seams"});
}

TEST(SceneSeams, ThatNearlyMeetOrAreHeldOnOneSideAreRefused) {
  expect_refusal(two_plates("seams {}", "", 0.502), "seams", {"nearly meet", "0.002 m apart", "seams.tolerance_m"});
  EXPECT_EQ(refusal(two_plates("", "", 0.502)).kind, "accepted");
  expect_refusal(two_plates("seams {}", "supports { edges: U_MIN kind: CLAMPED }"), "seams",
                 {"a support of shell 'wing' holds its seam with shell 'pane'", "the same edge of both",
                  "rules { first: \"wing\" second: \"pane\" kind: OPEN }"});
  EXPECT_EQ(refusal(two_plates("seams { rules { first: \"wing\" second: \"pane\" kind: OPEN } }",
                               "supports { edges: U_MIN kind: CLAMPED }"))
                .kind,
            "accepted");
}

// Two plates that overlap, each trimmed along one slanted line.
TEST(SceneSeams, AlongTrimsJoinShellsThatMayCrack) {
  const auto slanted = [](const std::string& seams, double shift, const std::string& more = "") {
    std::string text =
        two_plates(seams,
                   fmt::format("trims {{ points {{ u: {0} }} points {{ u: 0.5 }} points {{ u: 0.5 v: 0.5 }} "
                               "points {{ u: {1} v: 0.5 }} points {{ u: {0} }} }}",
                               shift, 0.04 + shift),
                   0.4);
    text.insert(
        text.find("elements_y: 16 }\n") + 17,
        "  trims { points {} points { u: 0.4 } points { u: 0.44 v: 0.5 } points { v: 0.5 } points {} } " + more + "\n");
    return text;
  };
  EXPECT_EQ(refusal(slanted("seams { rules { first: \"pane\" second: \"wing\" } }", 0.0)).kind, "accepted");
  expect_refusal(slanted("seams {}", 0.001), "seams", {"nearly meet", "0.000997 m apart", "seams.tolerance_m"});
  EXPECT_EQ(refusal(slanted("seams { tolerance_m: 0.001 }", 0.001)).kind, "accepted");
  const std::string cut = "cuts { points { u: 0.1 v: 0.1 } points { u: 0.1 v: 0.3 } }";
  EXPECT_EQ(refusal(slanted("seams {}", 0.0, cut)).kind, "accepted");
}

// The energy-release zone of a flaw continues over such an edge.
TEST(SceneSeams, TellShellsWhichOfTheirEdgesContinueInAnother) {
  const auto joined = [](const std::string& seams) {
    const std::string path = own_file("seam_scene.textproto");
    std::ofstream(path) << two_plates(seams);
    const auto setup = sunder::shell::build(sunder::scene::load(path, {}));
    std::remove(path.c_str());
    return std::pair(setup.shells[0].model.joined, setup.shells[1].model.joined);
  };
  EXPECT_EQ(joined("seams {}"), (std::pair<int, int>(sunder::shell::kUMax, sunder::shell::kUMin)));
  EXPECT_EQ(joined("seams { rules { first: \"pane\" second: \"wing\" kind: HINGE } }"), std::pair(0, 0));
  EXPECT_EQ(joined(""), std::pair(0, 0));
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
