// Seams of a scene: what is refused, with field and remedy.
#include "tests/coupler/small_scene.h"

namespace {

using namespace small_scene;

// Two plates side by side, more fields of the second one, and seams.
std::string scene(const std::string& seams, const std::string& shell = "", double x = 0.5) {
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
    const sunder::Error e = refusal(scene(fmt::format("seams {{ {} }}", rules)));
    EXPECT_EQ(e.kind, "accepted") << e.what();
  }
}

TEST(SceneSeams, OfShellsThatAreNotThereAreRefused) {
  expect_refusal(scene("seams { rules { first: \"pane\" second: \"wnig\" kind: HINGE } }"), "seams.rules[0].second",
                 {"'wnig' is no shell of this scene"});
  expect_refusal(scene("seams { rules { first: \"pane\" second: \"pane\" kind: HINGE } }"), "seams.rules[0].second",
                 {"a seam is between two shells"});
  expect_refusal(
      scene("seams { rules { first: \"pane\" second: \"wing\" } rules { first: \"wing\" second: \"pane\" } }"),
      "seams.rules[1]", {"says again"});
}

TEST(SceneSeams, ThatAreNotThereAreRefused) {
  const std::string fastened = "seams { rules { first: \"pane\" second: \"wing\" } }";
  EXPECT_EQ(refusal(scene(fastened)).kind, "accepted");
  expect_refusal(scene(fastened, "", 1.5), "seams.rules[0]", {"'pane' and 'wing'", "no whole edge in common"});
  EXPECT_EQ(refusal(scene("seams { rules { first: \"pane\" second: \"wing\" kind: OPEN } }", "", 1.5)).kind,
            "accepted");
}

TEST(SceneSeams, OfAToleranceOutOfRangeAreRefused) {
  for (const char* value : {"0", "-1e-6", "2", "nan"})
    expect_refusal(scene(fmt::format("seams {{ tolerance_m: {} }}", value)), "seams.tolerance_m",
                   {"above 0, at most 1"});
}

TEST(SceneSeams, WithWhatIsForOneShellAreRefused) {
  expect_refusal(scene("seams {}", "equilibrium {} supports { edges: ALL kind: CLAMPED }"), "shells[1].equilibrium",
                 {"leave one of them out"});
  expect_refusal(scene("seams {} transfer { kind: FLIP }"), "transfer", {"cannot go with seams"});
}

TEST(SceneSeams, ThatNearlyMeetOrAreHeldOnOneSideAreRefused) {
  expect_refusal(scene("seams {}", "", 0.502), "seams", {"nearly meet", "0.002 m apart", "seams.tolerance_m"});
  EXPECT_EQ(refusal(scene("", "", 0.502)).kind, "accepted");
  expect_refusal(scene("seams {}", "supports { edges: U_MIN kind: CLAMPED }"), "seams",
                 {"a support of shell 'wing' holds its seam with shell 'pane'", "give both of them"});
}

// A flaw's ground goes on there.
TEST(SceneSeams, TellShellsWhichOfTheirEdgesGoOnInAnother) {
  const auto joined = [](const std::string& seams) {
    const std::string path = own_file("seam_scene.textproto");
    std::ofstream(path) << scene(seams);
    const auto setup = sunder::shell::build(sunder::scene::load(path, {}));
    std::remove(path.c_str());
    return std::pair(setup.shells[0].model.joined, setup.shells[1].model.joined);
  };
  EXPECT_EQ(joined("seams {}"), (std::pair<int, int>(sunder::shell::kUMax, sunder::shell::kUMin)));
  EXPECT_EQ(joined("seams { rules { first: \"pane\" second: \"wing\" kind: HINGE } }"), std::pair(0, 0));
  EXPECT_EQ(joined(""), std::pair(0, 0));
}
