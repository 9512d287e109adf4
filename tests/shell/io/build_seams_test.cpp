// Seams of a scene: which edges they join and how, the strength that rules give them, and supports that do not fit.
#include "shell/io/build_seams.h"

#include <numbers>

#include "shell/geometry/edges.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/io/two_plates.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

using Groups = std::vector<std::vector<int>>;

// Groups of so many shells, with seams between these.
Groups groups_of(int shells, const std::vector<std::pair<int, int>>& seams) {
  RunSetup setup;
  const ShellModel model = brittle_sheet(2);
  for (int k = 0; k < shells; ++k) setup.shells.push_back({model});
  for (const auto& [first, second] : seams) {
    Seam seam;
    seam.first = first, seam.second = second;
    setup.stitches.seams.push_back(seam);
  }
  return joined_groups(setup);
}

}  // namespace

TEST(JoinedGroups, AreThoseThatSeamsConnect) {
  EXPECT_EQ(groups_of(0, {}), Groups());
  EXPECT_EQ(groups_of(3, {}), (Groups{{0}, {1}, {2}}));
  EXPECT_EQ(groups_of(6, {{4, 1}, {5, 3}, {1, 0}}), (Groups{{0, 1, 4}, {2}, {3, 5}}));
  EXPECT_EQ(groups_of(4, {{3, 2}, {2, 1}, {1, 0}}), (Groups{{0, 1, 2, 3}}));          // a chain
  EXPECT_EQ(groups_of(4, {{0, 3}, {1, 2}, {3, 1}, {3, 0}}), (Groups{{0, 1, 2, 3}}));  // two seams between two of them
  EXPECT_EQ(groups_of(2, {{1, 1}}), (Groups{{0}, {1}}));                              // a shell and itself
}

TEST(BuildSeams, OfPlatesInOnePlaneAreSmooth) {
  const RunSetup setup = small_scene::built(small_scene::two_plates("seams {}"));
  ASSERT_EQ(setup.stitches.seams.size(), 1u);
  const Seam& seam = setup.stitches.seams[0];
  const bool pane_first = seam.first == 0;
  EXPECT_EQ(seam.first + seam.second, 1);
  EXPECT_EQ(pane_first ? seam.first_edge : seam.second_edge, kUMax);
  EXPECT_EQ(pane_first ? seam.second_edge : seam.first_edge, kUMin);
  EXPECT_TRUE(seam.smooth);
  EXPECT_FALSE(seam.reversed);
  EXPECT_FALSE(seam.trimmed());
  EXPECT_EQ(seam.join, Join::kClamped);
  EXPECT_EQ(seam.angle, 0.0);
  EXPECT_NEAR(seam.length, 0.5, 1e-12);  // a sum over places along the edge
  EXPECT_EQ(seam.strength, 0.0);
  EXPECT_EQ(joined_groups(setup), (Groups{{0, 1}}));
}

TEST(BuildSeams, OfPlatesAtARightAngleAreCreases) {
  std::string text = small_scene::two_plates("seams {}", "", 0.25);
  const std::string flat = "position { x: 0.25 }";
  text.replace(text.find(flat), flat.size(), "position { x: 0.25 z: 0.25 } rotation { axis { y: 1 } angle_deg: -90 }");
  const RunSetup setup = small_scene::built(text);
  ASSERT_EQ(setup.stitches.seams.size(), 1u);
  EXPECT_FALSE(setup.stitches.seams[0].smooth);
  EXPECT_NEAR(setup.stitches.seams[0].angle, 0.5 * std::numbers::pi, 1e-12);  // round-off of the turn
}

TEST(BuildSeams, AreThereOnlyWhereTheSceneHasThem) {
  EXPECT_TRUE(small_scene::built(small_scene::two_plates("")).stitches.seams.empty());
  const RunSetup open =
      small_scene::built(small_scene::two_plates("seams { rules { first: \"wing\" second: \"pane\" kind: OPEN } }"));
  EXPECT_TRUE(open.stitches.seams.empty());
  EXPECT_TRUE(open.stitches.points.empty());
  EXPECT_EQ(joined_groups(open), (Groups{{0}, {1}}));
}

TEST(BuildSeams, ARuleNamesItsShellsInEitherOrder) {
  for (const char* names : {"first: \"pane\" second: \"wing\"", "first: \"wing\" second: \"pane\""}) {
    const RunSetup setup = small_scene::built(
        small_scene::two_plates(fmt::format("seams {{ rules {{ {} kind: HINGE strength: 2e4 }} }}", names)));
    ASSERT_EQ(setup.stitches.seams.size(), 1u);
    EXPECT_EQ(setup.stitches.seams[0].join, Join::kHinge);
    EXPECT_EQ(setup.stitches.seams[0].strength, 2e4);
  }
}

// A millionth of the largest shell's diagonal, 0.707 m.
TEST(BuildSeams, ToleranceIsAShareOfTheLargestShell) {
  EXPECT_EQ(small_scene::built(small_scene::two_plates("seams {}", "", 0.5 + 6e-7)).stitches.seams.size(), 1u);
  small_scene::expect_refusal(small_scene::two_plates("seams {}", "", 0.5 + 8e-7), "seams", {"nearly meet"});
  EXPECT_EQ(
      small_scene::built(small_scene::two_plates("seams { tolerance_m: 1e-6 }", "", 0.5 + 8e-7)).stitches.seams.size(),
      1u);
}

TEST(BuildSeams, WithoutACommonEdgeAreRefused) {
  const std::string fastened = "seams { rules { first: \"pane\" second: \"wing\" } }";
  EXPECT_EQ(small_scene::refusal(small_scene::two_plates(fastened)).kind, "accepted");
  small_scene::expect_refusal(small_scene::two_plates(fastened, "", 1.5), "seams.rules[0]",
                              {"'pane' and 'wing'", "no whole edge in common"});
  EXPECT_EQ(small_scene::refusal(
                small_scene::two_plates("seams { rules { first: \"pane\" second: \"wing\" kind: OPEN } }", "", 1.5))
                .kind,
            "accepted");
}

TEST(BuildSeams, ThatNearlyMeetOrAreHeldOnOneSideAreRefused) {
  small_scene::expect_refusal(small_scene::two_plates("seams {}", "", 0.502), "seams",
                              {"nearly meet", "0.002 m apart", "seams.tolerance_m"});
  EXPECT_EQ(small_scene::refusal(small_scene::two_plates("", "", 0.502)).kind, "accepted");
  small_scene::expect_refusal(small_scene::two_plates("seams {}", "supports { edges: U_MIN kind: CLAMPED }"), "seams",
                              {"a support of shell 'wing' holds its seam with shell 'pane'", "the same edge of both",
                               "rules { first: \"wing\" second: \"pane\" kind: OPEN }"});
  EXPECT_EQ(
      small_scene::refusal(small_scene::two_plates("seams { rules { first: \"wing\" second: \"pane\" kind: OPEN } }",
                                                   "supports { edges: U_MIN kind: CLAMPED }"))
          .kind,
      "accepted");
}

// Two plates that overlap, each trimmed along one slanted line.
TEST(BuildSeams, AlongTrimsJoinShellsThatMayCrack) {
  const auto slanted = [](const std::string& seams, double shift, const std::string& more = "") {
    std::string text = small_scene::two_plates(
        seams,
        fmt::format("trims {{ points {{ u: {0} }} points {{ u: 0.5 }} points {{ u: 0.5 v: 0.5 }} "
                    "points {{ u: {1} v: 0.5 }} points {{ u: {0} }} }}",
                    shift, 0.04 + shift),
        0.4);
    text.insert(
        text.find("elements_y: 16 }\n") + 17,
        "  trims { points {} points { u: 0.4 } points { u: 0.44 v: 0.5 } points { v: 0.5 } points {} } " + more + "\n");
    return text;
  };
  EXPECT_EQ(small_scene::refusal(slanted("seams { rules { first: \"pane\" second: \"wing\" } }", 0.0)).kind,
            "accepted");
  small_scene::expect_refusal(slanted("seams {}", 0.001), "seams",
                              {"nearly meet", "0.000997 m apart", "seams.tolerance_m"});
  EXPECT_EQ(small_scene::refusal(slanted("seams { tolerance_m: 0.001 }", 0.001)).kind, "accepted");
  const std::string cut = "cuts { points { u: 0.1 v: 0.1 } points { u: 0.1 v: 0.3 } }";
  EXPECT_EQ(small_scene::refusal(slanted("seams {}", 0.0, cut)).kind, "accepted");
}

// The energy-release zone of a flaw continues over such an edge.
TEST(BuildSeams, TellShellsWhichOfTheirEdgesContinueInAnother) {
  const auto joined = [](const std::string& seams) {
    const std::string path = small_scene::own_file("seam_scene.textproto");
    std::ofstream(path) << small_scene::two_plates(seams);
    const auto setup = build(scene::load(path, {}));
    std::remove(path.c_str());
    return std::pair(setup.shells[0].model.joined, setup.shells[1].model.joined);
  };
  EXPECT_EQ(joined("seams {}"), (std::pair<int, int>(kUMax, kUMin)));
  EXPECT_EQ(joined("seams { rules { first: \"pane\" second: \"wing\" kind: HINGE } }"), std::pair(0, 0));
  EXPECT_EQ(joined(""), std::pair(0, 0));
}

TEST(BuildSeams, WithASupportThatWouldDoNothingAreRefused) {
  const auto with = [](const std::string& pane, const std::string& wing, const std::string& rule) {
    std::string text = small_scene::two_plates("seams { " + rule + " }", wing);
    return text.insert(text.find("shells {") + 8, pane);
  };
  const std::string hinge = "rules { first: \"pane\" second: \"wing\" kind: HINGE }";
  const std::string left = " supports { edges: U_MAX kind: SIMPLY_SUPPORTED axes: Z }";
  const std::string right = " supports { edges: U_MIN kind: SIMPLY_SUPPORTED axes: Z }";
  const std::vector<std::string> words{"along the axis Z, where they depend on others that are free", "kind HINGE"};
  small_scene::expect_refusal(with("", right, ""), "shells[1].supports", words);
  small_scene::expect_refusal(with(left, right, ""), "shells[0].supports", words);
  for (const std::string& scene :
       {with(left, right, hinge),
        with(" supports { edges: U_MAX kind: CLAMPED }", " supports { edges: U_MIN kind: CLAMPED }", ""),
        with("", " supports { edges: V_MIN kind: SIMPLY_SUPPORTED axes: Z }", "")})
    EXPECT_EQ(small_scene::refusal(scene).kind, "accepted") << small_scene::refusal(scene).what();
}

// Which control points depend on others was settled with the support in place.
TEST(BuildSeams, ASupportThatIsReleasedHoldsNoSeam) {
  const auto with = [](const char* edge) {
    return small_scene::strong(fmt::format("supports {{ edges: {} kind: SIMPLY_SUPPORTED until_s: 0.5 }}", edge),
                               small_scene::kWing + "seams {}\n");
  };
  small_scene::expect_refusal(with("V_MIN"), "shells[0].supports",
                              {"are released at 0.5 s", "hold control points of the seam between 'pane' and 'wing'",
                               "hold a part off the seam"});
  EXPECT_EQ(small_scene::refusal(with("U_MIN")).kind, "accepted");
  EXPECT_EQ(small_scene::refusal(
                small_scene::strong("supports { regions { low {} high { u: 0.3 } } kind: CLAMPED until_s: 0.5 }",
                                    small_scene::kWing + "seams {}\n"))
                .kind,
            "accepted");
}
