// Mass that a scene lets small elements have: what is refused before and after shells are built.
#include <regex>

#include "tests/coupler/narrow_sheet.h"
#include "tests/coupler/small_scene.h"

using small_scene::built;
using small_scene::expect_refusal;
using small_scene::kScene;
using small_scene::refusal;
using small_scene::report;

namespace {

std::string scaled(const std::string& fields) { return kScene + "mass_scaling { " + fields + " }\n"; }

}  // namespace

TEST(MassScalingText, NeedsAStepOrAFactor) {
  expect_refusal(scaled(""), "mass_scaling", {"neither step_s nor factor", "factor: 1.5"});
  expect_refusal(scaled("step_s: 1e-5 factor: 2"), "mass_scaling.step_s", {"both given", "leave one of them out"});
}

TEST(MassScalingText, RefusesNumbersOutsideTheirBounds) {
  expect_refusal(scaled("step_s: -1e-5"), "mass_scaling.step_s", {"-1e-05", "positive"});
  expect_refusal(scaled("factor: 1"), "mass_scaling.factor", {"is 1;", "more than 1"});
  expect_refusal(scaled("factor: nan"), "mass_scaling.factor", {"nan"});
  expect_refusal(scaled("factor: 1.1 most_added: 0"), "mass_scaling.most_added", {"is 0;", "above 0"});
  expect_refusal(scaled("factor: 1.1 most_added: 1.5"), "mass_scaling.most_added", {"is 1.5;", "at most 1"});
  expect_refusal(scaled("factor: 1.1 most_error: 1"), "mass_scaling.most_error", {"is 1;", "below 1"});
  expect_refusal(scaled("factor: 1.1 modes: 0"), "mass_scaling.modes", {"is 0;", "1 to 100"});
  expect_refusal(scaled("factor: 1.1 modes: 101"), "mass_scaling.modes", {"is 101;"});
}

TEST(MassScalingText, RefusesShellsThatAreNotThere) {
  expect_refusal(scaled("factor: 1.1 shells: \"pain\""), "mass_scaling.shells[0]", {"'pain'", "pane"});
  expect_refusal(scaled("factor: 1.1 shells: [\"pane\", \"pane\"]"), "mass_scaling.shells[1]", {"names 'pane' again"});
  std::string bodies = scaled("factor: 1.1");
  bodies.erase(bodies.find("shells {"), bodies.find("bodies {") - bodies.find("shells {"));
  expect_refusal(bodies, "mass_scaling", {"the scene has none", "leave it out"});
}

TEST(MassScalingText, ExcludesTransferFibresAndStatics) {
  expect_refusal(scaled("factor: 1.1") + "transfer { kind: APIC }\n", "mass_scaling",
                 {"transfer", "leave one of them"});
  EXPECT_EQ(refusal(scaled("factor: 1.01") + "transfer { kind: DIRECT }\n").kind, "accepted");
  expect_refusal(
      small_scene::with_fields("fibres { compression_modulus: 1e5 shear_modulus: 1e5 }", "",
                               "contacts { first: \"pane\" second: \"pane\" }\nmass_scaling { factor: 1.1 }\n"),
      "shells[0].fibres", {"exclude mass_scaling"});
  std::string still = scaled("factor: 1.1");
  still.erase(still.find("bodies {"), still.find("mass_scaling") - still.find("bodies {"));
  for (const char* time : {"end_time_s: 1\n", "window_s: 1e-4\n"})
    still.erase(still.find(time), std::string(time).size());
  expect_refusal(still, "mass_scaling", {"nothing moves", "leave it out"});
}

TEST(MassScalingText, RefusesShellsThatCanCrack) {
  expect_refusal(small_scene::strong("", "mass_scaling { factor: 1.1 }\n"), "mass_scaling",
                 {"'pane', which can crack", "name other shells"});
  // the remedy: a shell beside it that cannot crack
  std::string wing = small_scene::kWing;
  wing.replace(wing.find("glass"), 5, "tough").replace(wing.find("x: 0.5"), 6, "x: 0.7");
  const std::string two = small_scene::strong(
      "", "materials { name: \"tough\" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22 }\n" + wing);
  expect_refusal(two + "mass_scaling { factor: 1.1 }\n", "mass_scaling", {"'pane'"});
  const std::string other = refusal(two + "mass_scaling { factor: 1.01 shells: \"wing\" }\n").what();
  EXPECT_EQ(other.find("can crack"), std::string::npos) << other;
  // a seam to a shell that can crack may part
  wing.replace(wing.find("x: 0.7"), 6, "x: 0.5");
  expect_refusal(small_scene::strong("",
                                     "materials { name: \"tough\" density: 2500 youngs_modulus: 70e9 poisson_ratio: "
                                     "0.22 }\nseams {}\n" +
                                         wing + "mass_scaling { factor: 1.1 shells: \"wing\" }\n"),
                 "mass_scaling", {"'wing', which can crack"});
}

TEST(MassScalingText, RefusesAStepThatIsReachedWithout) {
  expect_refusal(scaled("step_s: 1e-9"), "mass_scaling.step_s",
                 {"1e-09", "without added mass", "leave mass_scaling out"});
}

TEST(MassScalingText, RefusesMoreModesThanThereAre) {
  const std::string text = narrow_sheet::scene("factor: 1.2 most_added: 1 modes: 100", 2, 1);
  expect_refusal(text, "mass_scaling.modes", {"cannot be compared", "ask for fewer"});
}

// Twice the step puts three times their mass on two columns of 40 columns' worth.
TEST(MassScalingText, BoundsAreKeptAndTheStepThatWouldPassIsTold) {
  const auto remedied = [](const std::string& bounds, const std::string& said) {
    const std::string refused = narrow_sheet::scene("factor: 2 " + bounds);
    expect_refusal(refused, "mass_scaling.factor", {said, "step_s: ", "would pass"});
    const std::string told = refusal(refused).what();
    std::smatch step;
    ASSERT_TRUE(std::regex_search(told, step, std::regex("step_s: ([^ ]+) would pass"))) << told;
    const auto setup = built(narrow_sheet::scene("step_s: " + step.str(1) + " " + bounds));
    ASSERT_TRUE(setup.mass_scaling.has_value());
    EXPECT_GE(setup.mass_scaling->step_after, std::stod(step.str(1)));
    // and the search ends within a few hundredths of it
    expect_refusal(
        narrow_sheet::scene("step_s: " + fmt::format("{:.4g}", 1.08 * std::stod(step.str(1))) + " " + bounds),
        "mass_scaling.step_s", {said});
  };
  remedied("most_added: 0.02", "more than most_added, 2 %");
  remedied("most_added: 1 most_error: 0.004", "more than most_error, 0.4 %");
  EXPECT_EQ(refusal(narrow_sheet::scene("factor: 2 most_added: 1 most_error: 0.5")).kind, "accepted");
}

TEST(MassScalingText, SaysWhereOtherShellsLimitTheStep) {
  const std::string two =
      narrow_sheet::scene("factor: 2 most_added: 1 most_error: 0.9 shells: \"other\"") +
      "shells { name: \"other\" material: \"steel\" thickness_m: 0.004 plate { size_x_m: 2 size_y_m: "
      "1 elements_x: 20 elements_y: 10 pose { position { z: 1 } } } }\n";
  expect_refusal(two, "mass_scaling.factor",
                 {"shell 'sheet' gets no mass", "no longer step passes", "leave mass_scaling out"});
}

TEST(MassScalingText, CheckSaysWhatItDoes) {
  const std::string text = report(narrow_sheet::scene("factor: 2 most_added: 0.5 most_error: 0.2 modes: 4"));
  for (const char* said :
       {"mass scaling   adds ", "% of the mass; the stable step is ", "mode 1 of sheet: ", "mode 4 of sheet: "})
    EXPECT_NE(text.find(said), std::string::npos) << text;
  EXPECT_EQ(text.find("mode 5 of sheet"), std::string::npos) << text;
}
