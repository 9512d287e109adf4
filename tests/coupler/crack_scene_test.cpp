// Cuts, strengths and damage of a scene: what is refused, with field and remedy, and what becomes of the rest.
#include <cmath>

#include "tests/coupler/small_scene.h"

namespace {

using namespace small_scene;
using sunder::Vec2;

const std::string kStrong = "strength: 6e7 fracture_energy: 8 ";

// The small scene with more fields of the shell (line 10), the material and the scene.
std::string scene(const std::string& shell, const std::string& material = "", const std::string& more = "") {
  std::string text = replaced("poisson_ratio: 0.22 }", "poisson_ratio: 0.22 " + material + "}");
  text.insert(text.find("elements_y: 16 }\n") + 17, "  " + shell + "\n");
  return text + more;
}

void expect_refusal(const std::string& text, const std::string& field, const std::vector<std::string>& says,
                    const std::vector<std::string>& settings = {}) {
  const sunder::Error e = refusal(text, settings);
  EXPECT_EQ(e.status, sunder::Exit::kBadInput) << field;
  EXPECT_EQ(e.field, field) << e.what();
  for (const std::string& part : says) EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
}

sunder::shell::RunSetup built(const std::string& text, const std::vector<std::string>& settings = {}) {
  const std::string path = own_file("crack_scene.textproto");
  std::ofstream(path) << text;
  const auto scene = sunder::scene::load(path, settings);
  std::remove(path.c_str());
  return sunder::shell::build(scene);
}

}  // namespace

TEST(Cut, ThatLeavesTheDomainIsRefusedWithHowFar) {
  expect_refusal(scene("cuts { points { u: 0.1 v: 0.1 } points { u: 0.62 v: 0.1 } }"), "shells[0].cuts[0].points[1]",
                 {":10:", "(0.62, 0.1), 0.12 m outside the patch", "from 0 to 0.5 along u"});
  expect_refusal(scene("cuts { circle { center { u: 0.1 v: 0.3 } radius_m: 0.15 } }"), "shells[0].cuts[0].circle",
                 {"outside the patch", "from 0 to 0.5 along u"});
  expect_refusal(scene("cuts { spiral { center { u: 0.3 v: 0.3 } outer_radius_m: 0.25 turns: 2 } }"),
                 "shells[0].cuts[0].spiral", {"outside the patch"});
  expect_refusal(scene("cuts { curve { points { u: 0.1 v: 0.1 } points { u: 0.2 v: 0.9 } points { u: 0.3 v: 0.9 } "
                       "points { u: 0.4 v: 0.1 } } }"),
                 "shells[0].cuts[0].curve", {"reaches", "outside the patch"});
  // control points may lie outside as long as the curve does not; a circle may touch the border
  EXPECT_EQ(refusal(scene("cuts { curve { points { u: 0.1 v: 0.1 } points { u: 0.2 v: 0.6 } points { u: 0.3 v: 0.6 } "
                          "points { u: 0.4 v: 0.1 } } } cuts { circle { center { u: 0.25 v: 0.25 } radius_m: 0.25 } }"))
                .kind,
            "accepted");
}

TEST(Cut, OfTooFewPointsOrNoLengthIsRefused) {
  expect_refusal(scene("cuts { points { u: 0.1 v: 0.1 } }"), "shells[0].cuts[0].points",
                 {"has 1 points", "at least two"});
  expect_refusal(scene("cuts { time_s: 1 }"), "shells[0].cuts[0].points", {"circle, curve or spiral"});
  expect_refusal(scene("cuts { points { u: 0.1 v: 0.1 } points { u: 0.2 v: 0.1 } points { u: 0.2 v: 0.1 } }"),
                 "shells[0].cuts[0].points[2]", {"as points[1] is", "leave one of them out"});
  expect_refusal(scene("cuts { points { u: 0.1 v: 0.1 } points { u: nan v: 0.1 } }"), "shells[0].cuts[0].points[1]",
                 {"must be finite"});
  expect_refusal(scene("cuts { circle { center { u: 0.25 v: 0.25 } radius_m: 0.01 } }"),
                 "shells[0].cuts[0].circle.radius_m", {"half a spacing", "more elements"});
  expect_refusal(scene("cuts { circle { radius_m: 0.1 } }"), "shells[0].cuts[0].circle.center", {"is missing"});
  expect_refusal(scene("cuts { circle { center { u: inf v: 0.25 } radius_m: 0.1 } }"),
                 "shells[0].cuts[0].circle.center", {"must be finite"});
  expect_refusal(scene("cuts { points { u: 0.1 } points {} circle { center {} radius_m: 0.1 } }"),
                 "shells[0].cuts[0].points", {"give one of them"});
  expect_refusal(scene("cuts { curve { points {} points { u: 0.1 } points { v: 0.1 } } }"),
                 "shells[0].cuts[0].curve.points", {"has 3 points", "at least 4"});
  expect_refusal(scene("cuts { curve { degree: 7 } }"), "shells[0].cuts[0].curve.degree", {"2 to 5"});
  expect_refusal(scene("cuts { curve { closed: true points {} points { u: 0.1 } points { v: 0.1 } points {} } }"),
                 "shells[0].cuts[0].curve.points[3]", {"leave the last one out"});
  expect_refusal(scene("cuts { curve { points {} points {} points {} points {} } }"), "shells[0].cuts[0].curve",
                 {"has no length"});
  expect_refusal(scene("cuts { spiral { center { u: 0.2 v: 0.2 } inner_radius_m: 0.1 outer_radius_m: 0.1 turns: 1 } }"),
                 "shells[0].cuts[0].spiral.outer_radius_m", {"above inner_radius_m"});
  expect_refusal(scene("cuts { spiral { center { u: 0.2 v: 0.2 } outer_radius_m: 0.1 turns: 40 } }"),
                 "shells[0].cuts[0].spiral.turns", {"take fewer"});
}

TEST(Cut, ThatMeetsItselfIsRefusedWithBothSegmentsAndThePlace) {
  expect_refusal(scene("cuts { points { u: 0.1 v: 0.1 } points { u: 0.3 v: 0.1 } points { u: 0.2 v: 0.2 } "
                       "points { u: 0.2 v: 0.05 } }"),
                 "shells[0].cuts[0].points[2]",
                 {"from here to points[3]", "points[0] to points[1] at (0.2, 0.1)", "two cuts"});
  expect_refusal(scene("cuts { curve { points { u: 0.1 v: 0.1 } points { u: 0.5 v: 0.4 } points { u: 0 v: 0.4 } "
                       "points { u: 0.4 v: 0.1 } } }"),
                 "shells[0].cuts[0].curve", {"meets itself at (0.25", "two cuts"});
  // two cuts that cross each other are fine, and so is one that closes
  EXPECT_EQ(refusal(scene("cuts { points { u: 0.1 v: 0.1 } points { u: 0.3 v: 0.1 } } cuts { points { u: 0.2 v: 0.2 } "
                          "points { u: 0.2 v: 0.05 } } cuts { points { u: 0.3 v: 0.3 } points { u: 0.4 v: 0.3 } "
                          "points { u: 0.3 v: 0.4 } points { u: 0.3 v: 0.3 } }"))
                .kind,
            "accepted");
}

TEST(Cut, TakesSettingsAndKeepsItsTime) {
  const std::string text = scene("cuts { time_s: 0.25 circle { center { u: 0.25 v: 0.25 } radius_m: 0.1 } }");
  const auto cut = built(text, {"shells[pane].cuts[0].circle.radius_m=0.2"}).cuts[0];
  EXPECT_EQ(cut.time, 0.25);
  EXPECT_EQ(cut.points.front(), cut.points.back());
  for (const Vec2& p : cut.points) EXPECT_NEAR((p - Vec2(0.25, 0.25)).norm(), 0.2, 1e-12);
  expect_refusal(text, "shells[0].cuts[0].circle", {"set by --set"}, {"shells[pane].cuts[0].circle.radius_m=0.3"});
}

TEST(Healing, IsForDamageOnly) {
  const std::string tough = "strength: 6e7 fracture_energy: 3000 ";
  for (const char* mode : {"TIPS", "CUTS", "MODE_UNSPECIFIED"})
    expect_refusal(scene("", tough, fmt::format("fracture {{ mode: {} healing: false }}\n", mode)), "fracture.healing",
                   {"only mode DAMAGE", "leave it out"});
  EXPECT_FALSE(built(scene("", tough, "fracture { mode: DAMAGE healing: false }\n")).healing);
  EXPECT_TRUE(built(scene("", tough, "fracture { mode: DAMAGE }\n")).healing);
  EXPECT_FALSE(built(scene("", tough, "fracture { mode: DAMAGE }\n"), {"fracture.healing=false"}).healing);
}
