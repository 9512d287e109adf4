// Mistyped names in scenes are answered with the nearest right ones.
#include <string>

#include <gtest/gtest.h>

#include "coupler/scene/names.h"
#include "tests/coupler/small_scene.h"

using namespace small_scene;

// An error in the text names the mistyped word itself, also where its line ends with it.
TEST(EnumValue, IsRefusedWithItsPlaceAndTheNearestRightOne) {
  const auto refused = [](const std::string& more, int line, const std::string& says) {
    std::string text = kScene;
    const sunder::Error e = refusal(text.insert(text.find("elements_y: 16 }\n") + 17, more));
    EXPECT_EQ(e.status, sunder::Exit::kBadInput) << e.what();
    EXPECT_EQ(e.line, line) << e.what();
    EXPECT_NE(std::string(e.what()).find(says), std::string::npos) << e.what();
  };
  refused("  supports { edges: ALL kind: CLAMPD }\n", 10,
          ":10:31: kind: 'CLAMPD' is none of its values; did you mean 'CLAMPED'? They are CLAMPED, SIMPLY_SUPPORTED, ");
  refused("  supports {\n    edges: [U_MIN, V_MIX]\n    kind: CLAMPED }\n", 11,
          "edges: 'V_MIX' is none of its values; did you mean 'V_MIN' or 'V_MAX'?");
  refused("  stress_model: plane_stress\n", 10, "did you mean 'PLANE_STRESS'?");
  refused("  bending: STIFF\n", 10, "bending: 'STIFF' is none of its values; they are LAYERED or LINEAR");
}

TEST(Number, WithAUnitBehindItIsRefusedWithItsPlaceAndAnExample) {
  const std::string said = refusal(replaced("thickness_m: 0.004", "thickness_m: 4mm")).what();
  EXPECT_NE(said.find(":8:"), std::string::npos) << said;
  EXPECT_NE(said.find("numbers are in SI units and have none: 4 mm are 0.004"), std::string::npos) << said;
}

TEST(Reference, ToANameThatTheSceneDoesNotHaveIsRefusedWithTheNearestRightOne) {
  expect_refusal(replaced("material: \"glass\"\n  thickness", "material: \"galss\"\n  thickness"), "shells[0].material",
                 {"'galss' is no material of this scene (did you mean 'glass'?)"});
  expect_refusal(replaced("material: \"glass\"\n  sphere", "material: \"steel\"\n  sphere"), "bodies[0].material",
                 {"'steel' is no material of this scene (there are: glass)", "needs one for its density"});
  expect_refusal(replaced("pose { position { z: 0.1 } }", "launch { speed: 3 target: \"pan\" }"),
                 "bodies[0].launch.target", {"'pan' is no other shell or body of this scene (did you mean 'pane'?)"});
  expect_refusal(kScene + "contacts { first: \"pane\" second: \"bal\" }\n", "contacts[0].second",
                 {"'bal' is no shell or body of this scene (did you mean 'ball'?)"});
  expect_refusal(kScene + "joints { name: \"peg\" kind: BALL first: \"bell\" }\n", "joints[0].first",
                 {"'bell' is no body of this scene (did you mean 'ball'?)"});
  expect_refusal(kScene + "joints { name: \"peg\" kind: BALL first: \"ball\" second: \"pane\" }\n", "joints[0].second",
                 {"'pane' is no body of this scene (there are: ball)", "leave it out for the world"});
  expect_refusal(kScene + "output { probes { name: \"a\" shell: \"pain\" } }\n", "output.probes[0].shell",
                 {"'pain' is no shell of this scene (there are: pane); name a shell, or a body"});
  expect_refusal(kScene + "output { probes { name: \"a\" body: \"balls\" } }\n", "output.probes[0].body",
                 {"'balls' is no body of this scene (did you mean 'ball'?)"});
}

TEST(Setting, IsRefusedWithTheNearestRightName) {
  const auto says = [](const std::string& setting) {
    const sunder::Error e = refusal(kScene, {setting});
    EXPECT_EQ(e.kind, "bad_setting") << e.what();
    EXPECT_EQ(e.status, sunder::Exit::kBadInput) << e.what();
    return std::string(e.what());
  };
  const auto expect = [&](const std::string& setting, const std::string& words) {
    EXPECT_NE(says(setting).find(words), std::string::npos) << says(setting);
  };
  expect("shells.pane.thickness_m=1", "'shells' is a list; write shells[pane], by name or number from 0; it has ");
  expect("shells.thickness_m=1", "'shells' is a list; write shells[pane]");
  expect("bodies.0.material=x", "'bodies' is a list; write bodies[0]");
  expect("bodies.7.material=x", "'bodies' is a list; write bodies[ball], by name or number from 0; it has 1");
  expect("shells[pane].cuts.time_s=1", "'cuts' is a list; write cuts[0], by name or number from 0; it has 0");
  expect("bodies[bal].twist.linear.z=1", "bodies[bal] is not there; did you mean 'ball'?");
  expect("shell[pane].layers=4", "'shell' is no field of Scene; did you mean 'shells'?");
  expect("transfer.kind=APCI", "'APCI' is none of its values; did you mean 'APIC'");
  expect("window_s=soon", "'soon' is no number");
  expect("output.probes=a", "'probes' has fields: name one, as in output.probes[0].");
  expect("output.fields=STRESS", "'fields' is a list, which a setting does not change; write it into the scene");
  expect("shells[pane].plate=3", "'plate' has fields: name one, as in shells[pane].plate.");
  expect_refusal(
      kScene + "settle_window_s: 1.5e-4\n", "settle_window_s",
      {"is 0.00015 s, 1.5 times window_s, 0.0001 s; must be a whole multiple: give 0.0002, or leave it out"});
  expect("shells[pane].layers=many", "'many' is no whole number");
  expect("shells[pane].cuts[0].time_s=1", "cuts[0] is not there; it has 0, counted from 0");
}
