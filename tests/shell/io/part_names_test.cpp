// What names of shells mean where CAD faces divide a shell; the parts are made by hand.
#include "shell/io/part_names.h"

#include "tests/shell/io/cad_fixture.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// Shell 'pane' is itself; shell 'part' is three shells.
class PartNames : public testing::Test {
 protected:
  PartNames() {
    scene.message.add_shells()->set_name("pane");
    scene.message.add_shells()->set_name("part");
    for (const auto& [shell, name] :
         {std::pair{0, "pane"}, std::pair{1, "part.1"}, std::pair{1, "part.2"}, std::pair{1, "part.3"}}) {
      ScenePart part{shell, scene.message.shells(shell), 0, 0.0};
      part.message.set_name(name);
      parts.push_back(part);
    }
  }

  template <class F>
  std::string error(F&& f) const {
    try {
      f();
    } catch (const Error& e) {
      return e.what();
    }
    return "accepted";
  }
  std::string one(const std::string& name) const {
    return error([&] { shell_named(scene, parts, "probe", name); });
  }
  std::string checked() const {
    return error([&] { check_names(scene, parts); });
  }

  scene::LoadedScene scene;
  std::vector<ScenePart> parts;
};

TEST_F(PartNames, AShellOrAPartIsFound) {
  EXPECT_EQ(shell_named(scene, parts, "probe", "pane"), 0);
  EXPECT_EQ(shell_named(scene, parts, "probe", "part.3"), 3);
  EXPECT_EQ(shells_named(scene, parts, "probe", "part"), (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(shells_named(scene, parts, "probe", "part.2"), (std::vector<int>{2}));
  EXPECT_TRUE(shells_named(scene, parts, "probe", "ball").empty());
  EXPECT_TRUE(shells_named(scene, parts, "probe", "").empty());
}

TEST_F(PartNames, WhatMeansSeveralOrNoneIsRefused) {
  EXPECT_SAYS(one("part"), "probe: 'part' is 3 shells, part.1 to part.3; name one");
  EXPECT_SAYS(one("part.4"), "probe: is 'part.4', but 'part' is 3 shells, part.1 to part.3; name one of them");
  EXPECT_SAYS(one("pane.1"), "probe: is 'pane.1', but 'pane' is one shell; name pane");
  EXPECT_SAYS(one("ball"), "'ball' is no shell of this scene");
}

TEST_F(PartNames, EveryPlaceThatNamesAShellIsChecked) {
  proto::Scene& m = scene.message;
  proto::SeamRule& rule = *m.mutable_seams()->add_rules();
  proto::Probe& probe = *m.mutable_output()->add_probes();
  proto::Body& ball = *m.add_bodies();
  rule.set_first("part.1"), rule.set_second("pane"), probe.set_shell("part.2");
  ball.mutable_launch()->set_target("part");
  m.mutable_output()->add_probes()->set_body("ball");
  EXPECT_EQ(checked(), "accepted");
  rule.set_second("part");
  EXPECT_SAYS(checked(), "seams.rules[0].second: 'part' is 3 shells");
  rule.set_second("part.2"), rule.set_first("part.4");
  EXPECT_SAYS(checked(), "seams.rules[0].first: is 'part.4'");
  rule.set_first("pane"), probe.set_shell("part");
  EXPECT_SAYS(checked(), "output.probes[0].shell: 'part' is 3 shells, part.1 to part.3; name one");
  probe.set_shell("pane"), ball.mutable_launch()->set_target("part.5");
  EXPECT_SAYS(checked(), "bodies[0].launch.target: is 'part.5', but 'part' is 3 shells");
}

}  // namespace
