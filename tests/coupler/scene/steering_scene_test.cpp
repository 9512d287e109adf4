// Supports with a release, lines of strength, seams with a strength, and fields: refusals, and the built model.
#include <cmath>
#include <cstring>
#include <map>

#include "tests/coupler/small_scene.h"

namespace {

using namespace small_scene;
using sunder::Vec2;
using sunder::Vec3;

const std::string kStrong = "strength: 6e7 fracture_energy: 8 ";

// The small scene with additional fields of the shell, the material and the scene.
std::string scene(const std::string& shell, const std::string& more = "", const std::string& material = kStrong) {
  std::string text = replaced("poisson_ratio: 0.22 }", "poisson_ratio: 0.22 " + material + "}");
  text.insert(text.find("elements_y: 16 }\n") + 17, "  " + shell + "\n");
  return text + more;
}

const std::string kWing =
    "shells { name: \"wing\" material: \"glass\" thickness_m: 0.004 "
    "plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 pose { position { x: 0.5 } } } }\n";

sunder::shell::RunSetup built(const std::string& text) {
  const std::string path = own_file("steering_scene.textproto");
  std::ofstream(path) << text;
  const auto scene = sunder::scene::load(path, {});
  std::remove(path.c_str());
  return sunder::shell::build(scene);
}

std::string kept_until(const char* time, const char* edge = "U_MIN") {
  return fmt::format("supports {{ edges: {} kind: CLAMPED until_s: {} }}", edge, time);
}

/// Number of Gauss points of a shell with each factor of strength, which must be one of those given.
std::map<double, int> points_of(const sunder::shell::ShellModel& m) {
  std::map<double, int> out;
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int e = 0; e < m.tables.spans_u; ++e) ++out[m.strength_factor_at(q, e)];
  return out;
}

}  // namespace

TEST(SupportsUntilATime, AreBuilt) {
  const auto setup = built(scene(kept_until("0.5") + kept_until("0.25", "V_MAX") + kept_until("0.5", "U_MAX")));
  const auto& releases = setup.shells[0].model.releases;
  ASSERT_EQ(releases.size(), 2u);
  EXPECT_EQ(releases[0].from, 0.25);
  EXPECT_EQ(releases[1].from, 0.5);
  EXPECT_TRUE(releases[1].constraints.anchors.empty());
  EXPECT_EQ(setup.last_change, 0.5);  // cracking does not end before
}

TEST(SupportsUntilATime, AreRefusedWhereTheTimeIsWrong) {
  expect_refusal(scene(kept_until("0")), "shells[0].supports[0].until_s", {"must be positive"});
  expect_refusal(scene(kept_until("nan")), "shells[0].supports[0].until_s", {"must be positive and finite"});
  expect_refusal(scene(kept_until("1")), "shells[0].supports[0].until_s", {"the run ends at 1 s", "leave it out"});
  expect_refusal(scene(kept_until("0.5"), "fracture { latest_freeze_s: 0.4 }"), "shells[0].supports[0].until_s",
                 {"frozen at 0.4 s", "a later fracture.latest_freeze_s"});
  EXPECT_EQ(refusal(scene(kept_until("0.5"), "fracture { latest_freeze_s: 0.6 }")).kind, "accepted");
  // windows last 1e-4 s, and a support is released at the one that begins nearest
  expect_refusal(scene(kept_until("4e-5")), "shells[0].supports[0].until_s",
                 {"it would never hold", "give 5e-05 s or more"});
  expect_refusal(scene(kept_until("0.99996")), "shells[0].supports[0].until_s",
                 {"it would never be released", "leave it out"});
  EXPECT_EQ(refusal(scene(kept_until("5e-5"))).kind, "accepted");
  EXPECT_EQ(refusal(scene(kept_until("0.9999"))).kind, "accepted");
}

TEST(SupportsUntilATime, AreRefusedWhereNothingMoves) {
  std::string text = scene(kept_until("0.5") + " equilibrium {}");
  text.erase(text.find("bodies {"));
  for (const char* moving : {"end_time_s: 1\n", "window_s: 1e-4\n"}) text.erase(text.find(moving), strlen(moving));
  expect_refusal(text, "shells[0].supports[0].until_s", {"in this scene nothing moves", "leave it out"});
}

TEST(SupportsUntilATime, AreRefusedOnASeam) {
  const auto with = [](const char* edge) {
    return scene(fmt::format("supports {{ edges: {} kind: SIMPLY_SUPPORTED until_s: 0.5 }}", edge),
                 kWing + "seams {}\n");
  };
  expect_refusal(with("V_MIN"), "shells[0].supports",
                 {"are released at 0.5 s", "the seam between", "hold a part off the seam"});
  EXPECT_EQ(refusal(with("U_MIN")).kind, "accepted");
  EXPECT_EQ(
      refusal(scene("supports { regions { low {} high { u: 0.3 } } kind: CLAMPED until_s: 0.5 }", kWing + "seams {}\n"))
          .kind,
      "accepted");
}

TEST(SupportsUntilATime, MayEndBesideATrimmedSeamAndOnIt) {
  const auto trimmed = [](const std::string& support) {
    std::string text = small_scene::kScene;
    const std::string plate = "plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }\n";
    const std::size_t at = text.find(plate) + plate.size();
    const std::string rest =
        R"(  trims { points {} points { u: 0.3 } points { u: 0.35 v: 0.5 } points { v: 0.5 } points {} }
)" + support +
        R"(
}
shells {
  name: "rest" material: "glass" thickness_m: 0.004
  plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 14 elements_y: 15 }
  trims { points { u: 0.3 } points { u: 0.5 } points { u: 0.5 v: 0.5 } points { u: 0.35 v: 0.5 } points { u: 0.3 } }
)";
    return text.insert(at, rest) + "seams {}\n";
  };
  const std::string far = trimmed("supports { edges: U_MIN kind: CLAMPED until_s: 0.5 }");
  EXPECT_EQ(refusal(far).kind, "accepted") << refusal(far).what();
  const std::string on =  // ties follow the supports
      trimmed("supports { regions { low { u: 0.25 } high { u: 0.4 v: 0.5 } } kind: CLAMPED until_s: 0.5 }");
  EXPECT_EQ(refusal(on).kind, "accepted") << refusal(on).what();
}

TEST(StrengthLines, WeakenWhatIsWithinHalfTheirWidth) {
  const auto setup = built(
      scene("strength_lines { points { u: 0.1 v: 0 } points { u: 0.1 v: 0.3 } points { u: 0.4 v: 0.3 } width_m: 0.08 "
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
  const auto both = built(scene("", kWing + line + "}\n"));
  for (const auto& s : both.shells) {
    auto points = points_of(s.model);
    EXPECT_GT(points[0.5], 0) << s.model.name;
    EXPECT_EQ(points.size(), 2u) << s.model.name;
  }
  EXPECT_EQ(both.shells[0].model.strength_factor_at(0, 0), 1.0);
  const auto one = built(scene("", kWing + line + "shells: \"wing\" }\n"));
  EXPECT_TRUE(one.shells[0].model.strength_factor.empty());
  EXPECT_EQ(points_of(one.shells[1].model).size(), 2u);
}

// The chord of an arc lies below it; the line weakens the arc all the same, and not what lies opposite.
TEST(StrengthLines, InSpaceFollowACurvedShell) {
  const std::string shell =
      "name: \"vault\" material: \"glass\" thickness_m: 0.01 cylinder { radius_m: 1 length_m: 1 angle_deg: 120 "
      "elements_u: 96 elements_v: 48 }";
  const auto setup =
      built(scene("", "shells { " + shell +
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
    expect_refusal(scene("strength_lines { " + line + " }"), "shells[0].strength_lines[0]" + field, {says});
  };
  refused("points { u: 0.1 } width_m: 0.1 factor: 0.5", ".points", "two or more");
  refused("points { u: nan } points {} width_m: 0.1 factor: 0.5", ".points[0]", "must be finite");
  refused("points { u: 0.1 } points { u: 0.1 } width_m: 0.1 factor: 0.5", ".points[1]", "leave one of them out");
  refused(points + "factor: 0.5", ".width_m", "is missing");
  refused(points + "width_m: -1 factor: 0.5", ".width_m", "must be positive");
  refused(points + "width_m: 0.1", ".factor", "is missing");
  refused(points + "width_m: 0.1 factor: 0", ".factor", "must be positive");
  refused(points + "width_m: 0.01 factor: 0.5", ".width_m", "would have gaps; give 0.03128 m or more");
  EXPECT_EQ(refusal(scene("strength_lines { " + points + "width_m: 0.03128 factor: 0.5 }")).kind, "accepted");
  refused("points { u: 1 } points { u: 2 } width_m: 0.1 factor: 0.5", "", "passes no Gauss point");
  expect_refusal(scene("strength_lines { " + points + "width_m: 0.1 factor: 0.5 }", "", ""), "shells[0].strength_lines",
                 {"'glass' has not"});
}

TEST(StrengthLines, InSpaceAreRefusedWherePlaceOrShellIsWrong) {
  const std::string points = "points { x: -0.2 } points { x: 0.2 } ", rest = "width_m: 0.1 factor: 0.5 ";
  const auto refused = [](const std::string& line, const std::string& field, const std::string& says) {
    expect_refusal(scene("", "strength_lines { " + line + " }\n"), "strength_lines[0]" + field, {says});
  };
  refused("points { x: 1 }" + rest, ".points", "two or more");
  refused("points { x: 1 } points { x: inf }" + rest, ".points[1]", "must be finite");
  refused(points + "factor: 0.5", ".width_m", "is missing");
  refused(points + "width_m: 0.1 factor: 1e7", ".factor", "1e-06 to 1e+06");
  refused(points + "width_m: 0.01 factor: 0.5", ".width_m", "longest element of shell 'pane'");
  refused(points + rest + "shells: \"pain\"", ".shells[0]", "is no shell of this scene");
  refused("points { z: 3 } points { x: 0.2 z: 3 } " + rest, "", "passes no Gauss point of a shell");
  expect_refusal(scene("", "strength_lines { " + points + rest + " }\n", ""), "strength_lines[0]",
                 {"no shell has a material with a strength"});
  expect_refusal(scene("", "strength_lines { " + points + rest + " shells: \"pane\" }\n", ""),
                 "strength_lines[0].shells[0]", {"'glass' has no strength"});
}

TEST(SeamStrengths, AreBuiltOrRefused) {
  const auto with = [](const std::string& rule, const std::string& more = "") {
    return scene("", kWing + "seams { rules { first: \"pane\" second: \"wing\" " + rule + " } }\n" + more);
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

TEST(OutputFields, AreBuilt) {
  const auto setup = built(scene("",
                                 "output { fields: [STRESS, THICKNESS] probes { name: \"a\" shell: \"pane\" "
                                 "fields: BENDING_MOMENT } probes { name: \"b\" shell: \"pane\" body: \"ball\" } }\n"));
  using sunder::shell::FieldSet;
  EXPECT_TRUE(setup.fields.has(FieldSet::kStress) && setup.fields.has(FieldSet::kThickness));
  EXPECT_FALSE(setup.fields.has(FieldSet::kStrain));
  ASSERT_EQ(setup.probes.size(), 2u);
  EXPECT_TRUE(setup.probes[0].fields.has(FieldSet::kBendingMoment));
  EXPECT_TRUE(setup.probes[1].is_pair());
  EXPECT_TRUE(built(scene("")).fields.empty());
}

TEST(OutputFields, AreRefusedWhereNothingHasThem) {
  const auto refused = [](const std::string& output, const std::string& field, const std::string& says) {
    expect_refusal(scene("", "output { " + output + " }\n"), "output." + field, {says});
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
  expect_refusal(scene("", lump + "output { probes { name: \"a\" shell: \"pane\" body: \"lump\" } }\n"),
                 "output.probes[0].body", {"a soft body, whose contact with a shell is not measured"});
}

TEST(OutputFields, AreRefusedInScenesThatHaveNoShellOrNoBody) {
  const std::string pane = kScene.substr(kScene.find("shells {"), kScene.find("bodies {") - kScene.find("shells {"));
  std::string bodies = kScene, shells = kScene;
  bodies.erase(bodies.find(pane), pane.size()), shells.erase(shells.find("bodies {"));
  expect_refusal(bodies + "output { fields: STRESS }\n", "output.fields[0]",
                 {"the scene has no shell", "leave it out"});
  expect_refusal(shells + "output { fields: BODY_MOTION }\n", "output.fields[0]",
                 {"no rigid body and no shell that breaks"});
}
