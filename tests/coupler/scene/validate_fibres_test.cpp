// Fibres of a scene's shells: accepted scenes, and refusals with field and remedy.
#include <cmath>

#include "shell/mechanics/layers_weakening.h"
#include "tests/coupler/small_scene.h"

namespace {

using namespace small_scene;

const std::string kFibres = "fibres { compression_modulus: 1e7 shear_modulus: 1e7 friction: 0.3 }";

const std::string kOver = "size_x_m: 0.3 size_y_m: 0.3 elements_x: 8 elements_y: 8 pose { position { z: 0.005 } }";
const std::string kBeside = "size_x_m: 0.3 size_y_m: 0.5 elements_x: 8 elements_y: 16 pose { position { x: 0.4 } }";

// Two panes with fibres; `second`: fields of the second one.
std::string fibre_scene(const std::string& from = "", const std::string& to = "", const std::string& more = "",
                        const std::string& second = kFibres) {
  std::string text = kScene;
  text.replace(text.find("  plate {"), 0, "  " + kFibres + "\n");
  text += "shells {\n  name: \"over\"\n  material: \"glass\"\n  thickness_m: 0.004\n  " + second + "\n  plate { " +
          kOver + " }\n}\n";
  text += more;
  if (from.empty()) return text;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

// The same whose first pane has fibres that tear, by these fields, in a material that breaks.
std::string torn_scene(const std::string& fields, const std::string& more = "fracture { mode: DAMAGE }\n",
                       const std::string& material = "strength: 6e7 fracture_energy: 2000 ") {
  std::string text = fibre_scene("poisson_ratio: 0.22 }", "poisson_ratio: 0.22 " + material + "}", more);
  return text.insert(text.find("friction: 0.3"), fields + " ");
}

sunder::shell::RunSetup built_with_report(const std::string& text, std::string& report) {
  const std::string path = own_file("fibre_scene_test.textproto");
  std::ofstream(path) << text;
  const auto loaded = sunder::scene::load(path, {});
  sunder::shell::RunSetup setup = sunder::shell::build(loaded);
  report = sunder::shell::check_report(loaded, setup);
  std::remove(path.c_str());
  return setup;
}

}  // namespace

TEST(FibreScene, IsAcceptedAndReported) {
  std::string report;
  const auto setup = built_with_report(fibre_scene(), report);
  EXPECT_NE(report.find("fibres         on a grid of 0.0375 m"), std::string::npos) << report;
  EXPECT_FALSE(setup.shells_meet);                  // only fibres act between these
  EXPECT_NEAR(setup.fibre_spacing, 0.0375, 1e-12);  // the longest element, of the second
  const auto mixed = built_with_report(fibre_scene("", "", R"(shells {
  name: "third"
  material: "glass"
  thickness_m: 0.004
  plate { size_x_m: 0.3 size_y_m: 0.3 elements_x: 8 elements_y: 8 pose { position { z: 0.02 } } }
}
)"),
                                       report);
  EXPECT_TRUE(mixed.shells_meet);
}

TEST(FibreScene, WithoutFibresHasNoFibreModel) {
  std::string report;
  const auto setup = built_with_report(kScene, report);
  EXPECT_EQ(report.find("fibres"), std::string::npos) << report;
  EXPECT_EQ(setup.fibre_spacing, 0.0);
  const auto state = sunder::shell::make_state(setup.shells[0].model, sunder::Vec3::Zero(), 0);
  EXPECT_EQ(state.layers.fibres.capacity(), 0u);
}

TEST(FibreScene, StiffFibresShortenTheStep) {
  const auto step = [](const std::string& text) {
    std::string report;
    built_with_report(text, report);
    return std::stod(report.substr(report.find("stable step") + 11));
  };
  // square root of the modulus, once it dominates
  const double soft = step(fibre_scene("compression_modulus: 1e7", "compression_modulus: 1e12"));
  EXPECT_NEAR(step(fibre_scene("compression_modulus: 1e7", "compression_modulus: 1e14")), 0.1 * soft,
              0.02 * 0.1 * soft);
}

TEST(FibreScene, RefusesFieldsThatAreMissingOrOutOfRange) {
  const std::string f = "shells[0].fibres";
  expect_refusal(fibre_scene("compression_modulus: 1e7 ", ""), f + ".compression_modulus", {"is missing"});
  expect_refusal(fibre_scene("compression_modulus: 1e7", "compression_modulus: -1"), f + ".compression_modulus",
                 {"must be positive"});
  expect_refusal(fibre_scene("shear_modulus: 1e7 ", ""), f + ".shear_modulus", {"is missing"});
  expect_refusal(fibre_scene("shear_modulus: 1e7", "shear_modulus: nan"), f + ".shear_modulus", {"must be positive"});
  expect_refusal(fibre_scene("friction: 0.3", "friction: -0.1"), f + ".friction", {"not negative"});
  expect_refusal(fibre_scene("friction: 0.3", "friction: inf"), f + ".friction", {"must be finite"});
  expect_refusal(fibre_scene("friction: 0.3", "friction: 1e305"), f + ".friction", {"at most 1e+06"});
  expect_refusal(fibre_scene("friction: 0.3", "grid_spacing_m: 0.01"), f + ".grid_spacing_m", {"longest element"});
  expect_refusal(fibre_scene("friction: 0.3", "grid_spacing_m: 1"), f + ".grid_spacing_m", {"take less"});
  const std::string fine = R"(shells {
  name: "third"
  material: "glass"
  thickness_m: 0.001
  plate { size_x_m: 0.06 size_y_m: 0.06 elements_x: 8 elements_y: 8 pose { position { z: 0.02 } } }
  fibres { compression_modulus: 1e7 shear_modulus: 1e7 }
}
)";  // one grid for all: that of the coarsest
  expect_refusal(fibre_scene("", "", fine), "shells[2].fibres.grid_spacing_m",
                 {"is 0.0375 m for all shells", "more alike"});
  expect_refusal(fibre_scene("friction: 0.3", "grid_spacing_m: -1"), f + ".grid_spacing_m", {"must be positive"});
}

TEST(FibreScene, MayBreakAndBeCut) {
  EXPECT_EQ(
      refusal(fibre_scene("poisson_ratio: 0.22 }", "poisson_ratio: 0.22 strength: 5e7 fracture_energy: 8 }")).kind,
      "accepted");
  EXPECT_EQ(refusal(fibre_scene(kFibres, kFibres + " cuts { points { u: 0.1 v: 0.1 } points { u: 0.4 v: 0.4 } }")).kind,
            "accepted");
}

TEST(FibreScene, MayBeJoinedBySeams) {
  std::string report;
  const std::string beside = fibre_scene(kOver, kBeside, "seams {}\ncontacts { first: \"pane\" second: \"pane\" }\n");
  const auto setup = built_with_report(beside, report);
  EXPECT_EQ(setup.stitches.seams.size(), 1u);
  EXPECT_NE(report.find("fibres         on a grid of"), std::string::npos) << report;
  std::string ring = kScene;
  const std::string plate = "plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }";
  ring.replace(ring.find(plate), plate.size(), "annulus { inner_m: 0.1 outer_m: 0.3 element_m: 0.05 } " + kFibres);
  EXPECT_EQ(built_with_report(ring + "contacts { first: \"pane\" second: \"pane\" }\n", report).stitches.seams.size(),
            4u);
}

// The step of joined shells is found without fibres, and then shortened by them.
TEST(FibreScene, StiffFibresShortenTheStepOfJoinedShells) {
  const auto step = [](const std::string& modulus) {
    std::string report;
    built_with_report(fibre_scene(kOver, kBeside, "seams {}\n",
                                  "fibres { compression_modulus: " + modulus + " shear_modulus: 1e7 friction: 0.3 }"),
                      report);
    return std::stod(report.substr(report.find("stable step") + 11));
  };
  EXPECT_NEAR(step("1e14"), 0.1 * step("1e12"), 0.02 * 0.1 * step("1e12"));
}

TEST(FibreScene, RefusesFieldsThatExcludeFibres) {
  const std::string f = "shells[0].fibres";
  expect_refusal(fibre_scene("", "", "", ""), f,
                 {"have nothing to touch", "contacts { first: \"pane\" second: \"pane\" }"});
  EXPECT_EQ(refusal(fibre_scene("", "", "contacts { first: \"pane\" second: \"pane\" }\n", "")).kind, "accepted");
  expect_refusal(fibre_scene("poisson_ratio: 0.22 }", "poisson_ratio: 0.22 stiffness_damping_s: 1e-7 }"), f,
                 {"take mass_damping_per_s"});
  EXPECT_EQ(refusal(fibre_scene(kFibres, kFibres + " equilibrium {}")).kind, "accepted");
  expect_refusal(fibre_scene("", "", "transfer { kind: APIC }\n"), "transfer", {"cannot go with fibres"});
  expect_refusal(fibre_scene("", "", "coupling { scheme: ITERATED }\n"), "coupling.scheme", {"ITERATED"});
  expect_refusal(fibre_scene("", "", "fracture { latest_freeze_s: 0.5 }\n"), "fracture.latest_freeze_s",
                 {"leave it out"});
  expect_refusal(fibre_scene("", "", "contacts { first: \"pane\" second: \"over\" friction: 0.2 }\n"), "contacts[0]",
                 {"their own friction"});
}

TEST(FibreDamageScene, IsAcceptedAndReported) {
  std::string report;
  const auto setup = built_with_report(torn_scene("shear_strength: 5e5 crushing_strength: 8e6"), report);
  // 2 gamma G_f / (tau_f^2 l) = 4e10 / (2.5e11 0.0541)
  EXPECT_NE(report.find("fibre damage   from a shear stress of 5e+05 Pa, which a pressure of 1.67e+06 Pa holds, "
                        "complete at 2.96 times its shear; or from a pressure of 8e+06 Pa\n"),
            std::string::npos)
      << report;
  const double width = std::sqrt(3.0) * 0.5 / 16.0;
  const sunder::shell::FibreLaw& law = setup.shells[0].model.fibres;
  EXPECT_TRUE(law.breaks());
  EXPECT_EQ(law.shear_strength, 5e5);
  EXPECT_EQ(law.crushing_strength, 8e6);
  EXPECT_NEAR(law.brittleness, sunder::shell::brittleness(5e5, 1e7, 2000.0, width), 1e-12);
  EXPECT_FALSE(setup.shells[1].model.fibres.breaks());  // each shell for itself
  const auto narrow =
      built_with_report(torn_scene("shear_strength: 5e5", "fracture { mode: DAMAGE damage_width_m: 0.05 }\n"), report);
  EXPECT_NEAR(narrow.shells[0].model.fibres.brittleness, sunder::shell::brittleness(5e5, 1e7, 2000.0, 0.05), 1e-12);
  EXPECT_EQ(report.find("or from a pressure"), std::string::npos) << report;
}

TEST(FibreDamageScene, IsOffUnlessAskedFor) {
  std::string report;
  const auto setup = built_with_report(torn_scene(""), report);
  EXPECT_EQ(report.find("fibre damage"), std::string::npos) << report;
  EXPECT_FALSE(setup.shells[0].model.fibres.breaks());
  EXPECT_TRUE(sunder::shell::make_state(setup.shells[0].model, sunder::Vec3::Zero(), 0).layers.through.empty());
}

TEST(FibreDamageScene, RefusesStrengthsThatAreWrong) {
  const std::string shear = "shells[0].fibres.shear_strength", crush = "shells[0].fibres.crushing_strength";
  for (const char* bad : {"0", "-1", "nan", "inf"}) {
    expect_refusal(torn_scene(fmt::format("shear_strength: {}", bad)), shear, {"must be positive"});
    expect_refusal(torn_scene(fmt::format("shear_strength: 5e5 crushing_strength: {}", bad)), crush,
                   {"must be positive"});
  }
  expect_refusal(torn_scene("crushing_strength: 8e6"), crush, {"needs a shear_strength"});
  expect_refusal(torn_scene("shear_strength: 5e5 crushing_strength: 8.2e6"), crush, {"8.1e+06 Pa", "take less"});
  EXPECT_EQ(refusal(torn_scene("shear_strength: 5e5 crushing_strength: 8e6")).kind, "accepted");
  // friction holds 0.3 of the highest pressure
  const std::string strong =
      torn_scene("shear_strength: 3e6", "fracture { mode: DAMAGE }\n", "strength: 6e7 fracture_energy: 2e5 ");
  expect_refusal(strong, shear, {"slide at 2.43e+06 Pa", "raise friction or compression_modulus"});
  for (const char* remedy : {"shear_strength=2.4e6", "friction=0.4", "compression_modulus=1.5e7"})
    EXPECT_EQ(refusal(strong, {std::string("shells[pane].fibres.") + remedy}).kind, "accepted") << remedy;
  EXPECT_EQ(refusal(torn_scene("shear_strength: 3e6 crushing_strength: 8e6", "fracture { mode: DAMAGE }\n",
                               "strength: 6e7 fracture_energy: 2e5 "))
                .kind,
            "accepted");  // pressure tears them first
}

TEST(FibreDamageScene, RefusesWhatHasNoDamage) {
  const std::string shear = "shells[0].fibres.shear_strength";
  for (const char* mode : {"", "fracture { mode: TIPS }\n", "fracture { mode: CUTS }\n"})
    expect_refusal(torn_scene("shear_strength: 5e5", mode), shear, {"needs fracture { mode: DAMAGE }", "leave it out"});
  expect_refusal(torn_scene("shear_strength: 5e5", "fracture { mode: DAMAGE }\n", ""), shear,
                 {"needs a material with a strength", "'glass' has not"});
}

// The remedies that a refusal names are accepted.
TEST(FibreDamageScene, RefusesASofteningThatTheGridDoesNotResolve) {
  const std::string shear = "shells[0].fibres.shear_strength";
  const std::string text = torn_scene("shear_strength: 1e6");
  expect_refusal(text, shear,
                 {"localises over 0.0541 m", "= 0.04 m", "a shear_strength below 8.597e+05 Pa",
                  "a fracture_energy above 2706 J/m^2"});
  EXPECT_EQ(refusal(text, {"shells[pane].fibres.shear_strength=8.59e5"}).kind, "accepted");
  EXPECT_EQ(refusal(text, {"materials[glass].fracture_energy=2707"}).kind, "accepted");
  expect_refusal(torn_scene("shear_strength: 1"), shear, {"do not belong together", "above 27.32 Pa"});
  EXPECT_EQ(refusal(torn_scene("shear_strength: 27.4")).kind, "accepted");
}
