// Cuts of a scene: refusals with field and remedy, and the built model.
#include "tests/coupler/small_scene.h"

namespace {

using namespace small_scene;
using sunder::Vec2;

}  // namespace

TEST(Cut, ThatWouldNeverBeMadeIsRefused) {
  expect_refusal(with_fields("cuts { points { u: 0.1 v: 0.1 } points { u: 0.2 v: 0.1 } time_s: 1e3 }"),
                 "shells[0].cuts[0].time_s",
                 {"is 1000 s", "would never be made; give time_s below 1 s, or a later end_time_s"});
}

TEST(Cut, ThatLeavesTheDomainIsRefusedWithHowFar) {
  expect_refusal(with_fields("cuts { points { u: 0.1 v: 0.1 } points { u: 0.62 v: 0.1 } }"),
                 "shells[0].cuts[0].points[1]",
                 {":10:", "(0.62, 0.1), 0.12 m outside the patch", "from 0 to 0.5 along u"});
  expect_refusal(with_fields("cuts { circle { center { u: 0.1 v: 0.3 } radius_m: 0.15 } }"), "shells[0].cuts[0].circle",
                 {"outside the patch", "from 0 to 0.5 along u"});
  expect_refusal(with_fields("cuts { spiral { center { u: 0.3 v: 0.3 } outer_radius_m: 0.25 turns: 2 } }"),
                 "shells[0].cuts[0].spiral", {"outside the patch"});
  expect_refusal(
      with_fields("cuts { curve { points { u: 0.1 v: 0.1 } points { u: 0.2 v: 0.9 } points { u: 0.3 v: 0.9 } "
                  "points { u: 0.4 v: 0.1 } } }"),
      "shells[0].cuts[0].curve", {"reaches", "outside the patch"});
  // control points may lie outside if the curve does not; a circle may touch the border
  EXPECT_EQ(
      refusal(with_fields("cuts { curve { points { u: 0.1 v: 0.1 } points { u: 0.2 v: 0.6 } points { u: 0.3 v: 0.6 } "
                          "points { u: 0.4 v: 0.1 } } } cuts { circle { center { u: 0.25 v: 0.25 } radius_m: 0.25 } }"))
          .kind,
      "accepted");
}

TEST(Cut, OfTooFewPointsOrNoLengthIsRefused) {
  expect_refusal(with_fields("cuts { points { u: 0.1 v: 0.1 } }"), "shells[0].cuts[0].points",
                 {"has 1 points", "at least two"});
  expect_refusal(with_fields("cuts { time_s: 1 }"), "shells[0].cuts[0].points", {"circle, curve, spiral or line"});
  expect_refusal(with_fields("cuts { points { u: 0.1 v: 0.1 } points { u: 0.2 v: 0.1 } points { u: 0.2 v: 0.1 } }"),
                 "shells[0].cuts[0].points[2]", {"as points[1] is", "leave one of them out"});
  expect_refusal(with_fields("cuts { points { u: 0.1 v: 0.1 } points { u: nan v: 0.1 } }"),
                 "shells[0].cuts[0].points[1]", {"must be finite"});
  expect_refusal(with_fields("cuts { circle { center { u: 0.25 v: 0.25 } radius_m: 0.01 } }"),
                 "shells[0].cuts[0].circle.radius_m", {"half a spacing", "more elements"});
  expect_refusal(with_fields("cuts { circle { radius_m: 0.1 } }"), "shells[0].cuts[0].circle.center", {"is missing"});
  expect_refusal(with_fields("cuts { circle { center { u: inf v: 0.25 } radius_m: 0.1 } }"),
                 "shells[0].cuts[0].circle.center", {"must be finite"});
  expect_refusal(with_fields("cuts { points { u: 0.1 } points {} circle { center {} radius_m: 0.1 } }"),
                 "shells[0].cuts[0].points", {"give one of them"});
  expect_refusal(with_fields("cuts { curve { points {} points { u: 0.1 } points { v: 0.1 } } }"),
                 "shells[0].cuts[0].curve.points", {"has 3 points", "at least 4"});
  expect_refusal(with_fields("cuts { curve { degree: 7 } }"), "shells[0].cuts[0].curve.degree", {"2 to 5"});
  expect_refusal(with_fields("cuts { curve { closed: true points {} points { u: 0.1 } points { v: 0.1 } points {} } }"),
                 "shells[0].cuts[0].curve.points[3]", {"leave the last one out"});
  expect_refusal(with_fields("cuts { curve { points {} points {} points {} points {} } }"), "shells[0].cuts[0].curve",
                 {"has no length"});
  expect_refusal(
      with_fields("cuts { spiral { center { u: 0.2 v: 0.2 } inner_radius_m: 0.1 outer_radius_m: 0.1 turns: 1 } }"),
      "shells[0].cuts[0].spiral.outer_radius_m", {"above inner_radius_m"});
  expect_refusal(with_fields("cuts { spiral { center { u: 0.2 v: 0.2 } outer_radius_m: 0.1 turns: 40 } }"),
                 "shells[0].cuts[0].spiral.turns", {"take fewer"});
}

TEST(Cut, ThatMeetsItselfIsRefusedWithBothSegmentsAndThePlace) {
  expect_refusal(with_fields("cuts { points { u: 0.1 v: 0.1 } points { u: 0.3 v: 0.1 } points { u: 0.2 v: 0.2 } "
                             "points { u: 0.2 v: 0.05 } }"),
                 "shells[0].cuts[0].points[2]",
                 {"from here to points[3]", "points[0] to points[1] at (0.2, 0.1)", "two cuts"});
  expect_refusal(with_fields("cuts { curve { points { u: 0.1 v: 0.1 } points { u: 0.5 v: 0.4 } points { u: 0 v: 0.4 } "
                             "points { u: 0.4 v: 0.1 } } }"),
                 "shells[0].cuts[0].curve", {"meets itself at (0.25", "two cuts"});
  // two cuts may cross each other, and a cut may be closed
  EXPECT_EQ(
      refusal(with_fields("cuts { points { u: 0.1 v: 0.1 } points { u: 0.3 v: 0.1 } } cuts { points { u: 0.2 v: 0.2 } "
                          "points { u: 0.2 v: 0.05 } } cuts { points { u: 0.3 v: 0.3 } points { u: 0.4 v: 0.3 } "
                          "points { u: 0.3 v: 0.4 } points { u: 0.3 v: 0.3 } }"))
          .kind,
      "accepted");
}

TEST(Cut, TakesSettingsAndKeepsItsTime) {
  const std::string text = with_fields("cuts { time_s: 0.25 circle { center { u: 0.25 v: 0.25 } radius_m: 0.1 } }");
  const auto cut = built(text, {"shells[pane].cuts[0].circle.radius_m=0.2"}).shells[0].fracture.cuts[0];
  EXPECT_EQ(cut.time, 0.25);
  ASSERT_EQ(cut.lines.size(), 1u);
  EXPECT_TRUE(cut.on_edges.empty());
  EXPECT_EQ(cut.lines[0].front(), cut.lines[0].back());
  for (const Vec2& p : cut.lines[0]) EXPECT_NEAR((p - Vec2(0.25, 0.25)).norm(), 0.2, 1e-12);
  expect_refusal(text, "shells[0].cuts[0].circle", {"set by --set"}, {"shells[pane].cuts[0].circle.radius_m=0.3"});
}

TEST(Cut, GrowsInPiecesThatFollowOneAnother) {
  const std::string line = "cuts { points { u: 0.1 v: 0.1 } points { u: 0.3 v: 0.1 } points { u: 0.3 v: 0.25 } ";
  const auto setup = built(
      with_fields(line + "time_s: 0.2 until_s: 0.6 } cuts { points { u: 0.1 v: 0.4 } points { u: 0.2 v: 0.4 } }"));
  std::vector<sunder::shell::PrescribedCut> cuts = setup.shells[0].fracture.cuts;
  EXPECT_EQ(cuts.back().number, 1);
  EXPECT_FALSE(cuts.back().goes_on);
  cuts.pop_back();
  // 0.35 m in pieces of at most a spacing, 0.5 m / 16
  ASSERT_EQ(cuts.size(), 12u);
  double length = 0.0;
  for (std::size_t k = 0; k < cuts.size(); ++k) {
    ASSERT_EQ(cuts[k].lines.size(), 1u);
    const std::vector<Vec2>& p = cuts[k].lines[0];
    for (std::size_t i = 1; i < p.size(); ++i) length += (p[i] - p[i - 1]).norm();
    EXPECT_NEAR(cuts[k].time, 0.2 + 0.4 * length / 0.35, 1e-12);
    EXPECT_EQ(cuts[k].number, 0);
    EXPECT_EQ(cuts[k].goes_on, k + 1 < cuts.size());
    if (k > 0) {
      EXPECT_EQ(p.front(), cuts[k - 1].lines[0].back());
    }
  }
  EXPECT_NEAR(length, 0.35, 1e-12);
  EXPECT_EQ(cuts.front().lines[0].front(), Vec2(0.1, 0.1));
  EXPECT_EQ(cuts.back().lines[0].back(), Vec2(0.3, 0.25));
  expect_refusal(with_fields(line + "time_s: 0.2 until_s: 0.2 }"), "shells[0].cuts[0].until_s", {"give a later time"});
  for (const char* late : {"7e3", "1"})
    expect_refusal(with_fields(line + "until_s: " + late + " }"), "shells[0].cuts[0].until_s",
                   {"would not become whole; give until_s below 1 s, or a later end_time_s"});
  EXPECT_EQ(built(with_fields(line + "until_s: 0.999999 }")).shells[0].fracture.cuts.size(), 12u);
  expect_refusal(with_fields(line + "until_s: 0.5 }", "", "fracture { latest_freeze_s: 0.5 }\n"),
                 "shells[0].cuts[0].until_s", {"below 0.5 s, or a later fracture.latest_freeze_s"});
}

TEST(Cut, WithMorePointsThanAShellCanResolveIsRefused) {
  std::string points;
  for (int k = 0; k <= 20000; ++k) points += fmt::format("points {{ u: {} v: 0.1 }} ", 0.1 + 1e-5 * k);
  expect_refusal(with_fields("cuts { " + points + "}"), "shells[0].cuts[0]", {"has 20001 points", "at most 20000"});
}
