// Fields of the output: refusals, and the built model.
#include "tests/coupler/small_scene.h"

namespace {

using namespace small_scene;

}  // namespace

TEST(OutputFields, AreBuilt) {
  const auto setup =
      built(strong("",
                   "output { fields: [STRESS, THICKNESS] probes { name: \"a\" shell: \"pane\" "
                   "fields: BENDING_MOMENT } probes { name: \"b\" shell: \"pane\" body: \"ball\" } }\n"));
  using sunder::shell::FieldSet;
  EXPECT_TRUE(setup.fields.has(FieldSet::kStress) && setup.fields.has(FieldSet::kThickness));
  EXPECT_FALSE(setup.fields.has(FieldSet::kStrain));
  ASSERT_EQ(setup.probes.size(), 2u);
  EXPECT_TRUE(setup.probes[0].fields.has(FieldSet::kBendingMoment));
  EXPECT_TRUE(setup.probes[1].is_pair());
  EXPECT_TRUE(built(strong("")).fields.empty());
}

TEST(OutputFields, AreRefusedWhereNothingHasThem) {
  const auto refused = [](const std::string& output, const std::string& field, const std::string& says) {
    expect_refusal(strong("", "output { " + output + " }\n"), "output." + field, {says});
  };
  refused("fields: FIELD_UNSPECIFIED", "fields[0]", "name STRESS, STRAIN");
  refused("fields: [STRESS, STRESS]", "fields[1]", "names STRESS twice");
  refused("fields: PLASTIC_STRAIN", "fields[0]", "no shell's material has a yield_stress");
  refused("probes { name: \"a\" shell: \"pane\" fields: BODY_MOTION }", "probes[0].fields[0]", "probe the body");
  refused("probes { name: \"a\" body: \"ball\" fields: STRESS }", "probes[0].fields", "leave one out");
  refused("probes { name: \"a\" shell: \"pane\" body: \"ball\" at { u: 0.1 } }", "probes[0].at",
          "leave one of them out");
  refused("probes { name: \"a\" shell: \"pain\" body: \"ball\" }", "probes[0].shell", "is no shell of this scene");
  const std::string lump =
      "materials { name: \"rubber\" density: 1000 youngs_modulus: 1e6 poisson_ratio: 0.45 }\n"
      "soft_bodies { name: \"lump\" material: \"rubber\" sphere { radius_m: 0.05 } spacing_m: 0.01 "
      "pose { position { x: 0.3 z: 0.1 } } }\n";
  expect_refusal(strong("", lump + "output { probes { name: \"a\" shell: \"pane\" body: \"lump\" } }\n"),
                 "output.probes[0].body", {"a soft body, whose contact with a shell is not measured"});
}

TEST(OutputFields, AreOfTwoShellsToo) {
  const std::string second =
      "shells { name: \"lid\" material: \"glass\" thickness_m: 0.004 plate { size_x_m: 0.3 size_y_m: 0.3 elements_x: "
      "16 "
      "elements_y: 16 pose { position { z: -0.1 } } } }\n";
  const auto probe = [&](const std::string& more) {
    return second + "output { thick_shells: true probes { name: \"a\" " + more + " } }\n";
  };
  const auto setup = built(strong("", probe("shell: \"lid\" other_shell: \"pane\"")));
  EXPECT_TRUE(setup.thick_shells);
  ASSERT_EQ(setup.probes.size(), 1u);
  EXPECT_TRUE(setup.probes[0].is_pair());
  EXPECT_EQ(setup.probes[0].shell, 1);
  EXPECT_EQ(setup.probes[0].other, 0);
  const auto refused = [&](const std::string& more, const std::string& says) {
    expect_refusal(strong("", probe(more)), "output.probes[0].other_shell", {says});
  };
  refused("shell: \"pane\" body: \"ball\" other_shell: \"lid\"", "a body is given; leave one of them out");
  refused("other_shell: \"lid\"", "shell is missing; name the first one");
  refused("shell: \"pane\" other_shell: \"lid\" at { u: 0.1 }", "those of a point; leave them out");
  refused("shell: \"pane\" other_shell: \"lid\" fields: STRESS", "those of a point; leave them out");
  refused("shell: \"pane\" other_shell: \"pane\"", "is 'pane', as shell is; name another one");
  refused("shell: \"pane\" other_shell: \"lit\"", "is no shell of this scene");
}

TEST(OutputFields, AreNotOfShellsThatSeamsJoinOrThatDoNotMove) {
  const auto plate = [](const std::string& name, double x) {
    return "shells { name: \"" + name +
           "\" material: \"glass\" thickness_m: 0.004 plate { size_x_m: 0.3 size_y_m: 0.3 " +
           "elements_x: 8 elements_y: 8 pose { position { x: " + std::to_string(x) + " z: -0.1 } } } }\n";
  };
  // `far` hangs on `lid` by `side`
  const std::string shells = plate("lid", 0.0) + plate("side", 0.3) + plate("far", 0.6) + "seams { }\n";
  const auto probe = [&](const std::string& one, const std::string& other) {
    return shells + "output { probes { name: \"ball\" body: \"ball\" } probes { name: \"a\" shell: \"" + one +
           "\" other_shell: \"" + other + "\" } }\n";
  };
  for (const char* other : {"side", "far"})
    expect_refusal(strong("", probe("lid", other)), "output.probes[1].other_shell",
                   {std::string("is '") + other + "', which seams join to 'lid'", "leave the probe out"});
  EXPECT_EQ(built(strong("", probe("pane", "far"))).probes.size(), 2u);
  std::string still = kScene;
  for (const char* field : {"end_time_s:", "window_s:"})
    still.erase(still.find(field), still.find('\n', still.find(field)) - still.find(field));
  still.erase(still.find("bodies {"));
  expect_refusal(still + plate("lid", 0.0) + "output { probes { name: \"a\" shell: \"pane\" other_shell: \"lid\" } }\n",
                 "output.probes[0].other_shell", {"in this scene nothing moves", "leave the probe out"});
}

TEST(OutputFields, AreRefusedInScenesThatHaveNoShellOrNoBody) {
  const std::string pane = kScene.substr(kScene.find("shells {"), kScene.find("bodies {") - kScene.find("shells {"));
  std::string bodies = kScene, shells = kScene;
  bodies.erase(bodies.find(pane), pane.size()), shells.erase(shells.find("bodies {"));
  expect_refusal(bodies + "output { fields: STRESS }\n", "output.fields[0]",
                 {"the scene has no shell", "leave it out"});
  expect_refusal(bodies + "output { thick_shells: true }\n", "output.thick_shells",
                 {"the scene has no shell; leave it out"});
  expect_refusal(shells + "output { fields: BODY_MOTION }\n", "output.fields[0]",
                 {"no rigid body and no shell that breaks"});
}
