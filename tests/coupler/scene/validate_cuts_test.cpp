// Cuts of a scene: refusals with field and remedy, and the built model.
#include "tests/coupler/small_scene.h"

namespace {

using namespace small_scene;

}  // namespace

TEST(Cut, ThatWouldNeverBeMadeIsRefused) {
  expect_refusal(with_fields("cuts { points { u: 0.1 v: 0.1 } points { u: 0.2 v: 0.1 } time_s: 1e3 }"),
                 "shells[0].cuts[0].time_s",
                 {"is 1000 s", "would never be made; give time_s below 1 s, or a later end_time_s"});
}

TEST(Cut, OfTooFewPointsOrNoLengthIsRefused) {
  expect_refusal(with_fields("cuts { points { u: 0.1 v: 0.1 } }"), "shells[0].cuts[0].points",
                 {"has 1 points", "at least two"});
  expect_refusal(with_fields("cuts { time_s: 1 }"), "shells[0].cuts[0].points", {"circle, curve, spiral or line"});
  expect_refusal(with_fields("cuts { points { u: 0.1 v: 0.1 } points { u: nan v: 0.1 } }"),
                 "shells[0].cuts[0].points[1]", {"must be finite"});
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
  expect_refusal(
      with_fields("cuts { spiral { center { u: 0.2 v: 0.2 } inner_radius_m: 0.1 outer_radius_m: 0.1 turns: 1 } }"),
      "shells[0].cuts[0].spiral.outer_radius_m", {"above inner_radius_m"});
}

TEST(Cut, ThatWouldNotBecomeWholeIsRefused) {
  const std::string line = "cuts { points { u: 0.1 v: 0.1 } points { u: 0.3 v: 0.1 } points { u: 0.3 v: 0.25 } ";
  expect_refusal(with_fields(line + "time_s: 0.2 until_s: 0.2 }"), "shells[0].cuts[0].until_s", {"give a later time"});
  for (const char* late : {"7e3", "1"})
    expect_refusal(with_fields(line + "until_s: " + late + " }"), "shells[0].cuts[0].until_s",
                   {"would not become whole; give until_s below 1 s, or a later end_time_s"});
  expect_refusal(with_fields(line + "until_s: 0.5 }", "", "fracture { latest_freeze_s: 0.5 }\n"),
                 "shells[0].cuts[0].until_s", {"below 0.5 s, or a later fracture.latest_freeze_s"});
}
