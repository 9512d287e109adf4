// The report of a scene before it runs: counts, steps, what the spacing resolves, and scenes whose step does not fit.
#include "shell/io/check.h"

#include <cmath>

#include "tests/shell/io/two_plates.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

std::string with_value(const std::string& from, const std::string& to) { return small_scene::replaced(from, to); }

bool reports(const std::string& text, const std::string& line) { return text.find(line) != std::string::npos; }

// The number that stands behind `before` in a text.
double number_after(const std::string& text, const std::string& before) {
  const std::size_t at = text.find(before);
  EXPECT_NE(at, std::string::npos) << before << " in " << text;
  return at == std::string::npos ? 0.0 : std::stod(text.substr(at + before.size()));
}

}  // namespace

TEST(CheckReport, OfNothingIsItsNameAndNoBodies) {
  RunSetup setup;
  setup.name = "empty";
  EXPECT_EQ(check_report({}, setup), "scene          empty\nbodies         0\n");
}

// 16 x 16 elements of degree 2 have 18 x 18 control points and 2 x 2 Gauss points each, through two layers.
TEST(CheckReport, CountsAreExact) {
  const std::string said = small_scene::report(small_scene::kScene);
  for (const char* line :
       {"scene          small\n", "bodies         1\n", "shell          pane\n", "control points 324\n",
        "gauss points   1024\n", "layer points   2048\n", "spacing        0.03125 m\n"})
    EXPECT_TRUE(reports(said, line)) << line << said;
  for (const char* line : {"together", "fracture", "strength", "mass scaling", "fibres", "soft body"})
    EXPECT_FALSE(reports(said, line)) << line << said;  // the scene has none of it
}

TEST(CheckReport, TellsWhatLooksLikeAnotherUnit) {
  const std::string warning = "warning        materials[glass].density is 2.5 kg/m^3, about that of air";
  EXPECT_TRUE(reports(small_scene::report(with_value("density: 2500", "density: 2.5")), warning));
  EXPECT_FALSE(reports(small_scene::report(small_scene::kScene), "warning        materials["));
}

// A compression wave passes an element of h in h sqrt(rho (1 - nu^2) / E). A step is stable below a share of that.
TEST(CheckReport, SubstepsFollowFromTheStableStep) {
  const std::string said = small_scene::report(small_scene::kScene);
  const double step = number_after(said, "stable step    ");
  const double passage = 0.03125 * std::sqrt(2500.0 * (1.0 - 0.22 * 0.22) / 70e9);
  EXPECT_LT(step, passage);
  EXPECT_GT(step, 0.25 * passage);
  const double a_window = std::ceil(1e-4 / (0.8 * step));  // safety 0.8; the step has four digits, and 26 is from 25.9
  EXPECT_TRUE(reports(said, fmt::format("substeps       at most {:.0f}, {:.0f} a window of 0.0001 s, until 1 s\n",
                                        1e4 * a_window, a_window)))
      << said;
  const std::string asked = small_scene::report(small_scene::kScene + "time_step_s: 2e-6\n");
  EXPECT_TRUE(reports(asked, "substeps       at most 500000, 50 a window of 0.0001 s, until 1 s\n")) << asked;
}

TEST(CheckReport, SeveralShellsAreAddedUp) {
  const std::string said = small_scene::report(small_scene::two_plates("seams {}"));
  EXPECT_TRUE(reports(said, "shell          pane\n")) << said;
  EXPECT_TRUE(reports(said, "shell          wing\n")) << said;
  EXPECT_TRUE(reports(said, "together       2 shells, 4096 layer points, 1 seams\n")) << said;
  EXPECT_TRUE(reports(small_scene::report(small_scene::two_plates("")), "4096 layer points, 0 seams\n"));
}

// Softening takes 2 E G_f / f^2, 0.311 mm of glass, and an element resolves it below that over the root of three.
TEST(CheckReport, TellsWhetherTheSpacingResolvesTheFractureEnergy) {
  // a hundred and more times as many elements along each side: no advice
  const std::string brittle = small_scene::report(small_scene::strong(""));
  EXPECT_TRUE(reports(brittle,
                      "fracture       cracks start by the strength at once, and run by the fracture energy, at "
                      "any spacing that can be afforded\n"))
      << brittle;
  const std::string coarse = small_scene::report(small_scene::strong("", "", "strength: 6e7 fracture_energy: 800 "));
  EXPECT_TRUE(reports(coarse,
                      "fracture       the spacing does not resolve the softening (that needs below 0.018 m, or more "
                      "than 1.39e+03 J/m^2)"))
      << coarse;
  const std::string tough = small_scene::report(small_scene::strong("", "", "strength: 6e7 fracture_energy: 1400 "));
  EXPECT_TRUE(reports(tough, "fracture       the spacing resolves the fracture energy (needs below 0.0314 m)\n"))
      << tough;
}

TEST(CheckReport, TellsTheRangeOfTheStrength) {
  const std::string box = "strength_regions { low {} high { u: 0.25 v: 0.5 } factor: 0.25 } ";
  const std::string said = small_scene::report(small_scene::strong(box));
  EXPECT_TRUE(reports(said, "strength       0.25 to 1 times the material's\n")) << said;
  EXPECT_FALSE(reports(small_scene::report(small_scene::strong("")), "times the material's"));
}

TEST(CheckReport, AWindowShorterThanTheStableStepIsRefusedWithOneThatDoes) {
  const Error e = small_scene::refusal(with_value("window_s: 1e-4", "window_s: 1e-6"));
  EXPECT_EQ(e.status, Exit::kBadInput);
  EXPECT_EQ(e.field, "window_s");
  EXPECT_EQ(e.line, 3);
  EXPECT_TRUE(reports(e.what(), "is 1e-06 s, shorter than the stable step of the shell, ")) << e.what();
  const double enough = number_after(e.what(), "give at least ");
  EXPECT_EQ(small_scene::refusal(with_value("window_s: 1e-4", fmt::format("window_s: {}", enough))).kind, "accepted");
}

TEST(CheckReport, ATimeStepAboveTheStableOneIsRefusedWithOneThatDoes) {
  const Error e = small_scene::refusal(small_scene::kScene + "time_step_s: 5e-5\n");
  EXPECT_EQ(e.field, "time_step_s");
  EXPECT_EQ(e.line, 17);
  EXPECT_TRUE(reports(e.what(), "is 5e-05 s; the stable step of shell 'pane' is ")) << e.what();
  const double most = number_after(e.what(), "with a margin at most ");
  EXPECT_EQ(small_scene::refusal(small_scene::kScene + fmt::format("time_step_s: {}\n", most)).kind, "accepted");
}

TEST(CheckReport, AWindowOfTooManySubstepsIsRefused) {
  small_scene::expect_refusal(small_scene::kScene + "time_step_s: 9e-11\n", "time_step_s",
                              {"leads to 1.11e+06 substeps a window; at most 1e+06"});
}

TEST(CheckReport, AShellThatIsHeldAllOverHasNoStep) {
  std::string text = with_value("elements_x: 16 elements_y: 16 }",
                                "elements_x: 2 elements_y: 2 }\n  supports { edges: ALL kind: CLAMPED }");
  text.erase(text.find("bodies {"));  // the ball would pass between Gauss points
  small_scene::expect_refusal(text, "shells[0].supports",
                              {"hold every control point of shell 'pane'", "take more elements"});
}
