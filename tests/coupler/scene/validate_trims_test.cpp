// Trim loops of a scene: refusals with field and remedy, and the built model.
#include <cmath>
#include <numbers>

#include "tests/coupler/small_scene.h"

namespace {

using namespace small_scene;

std::string trimmed_pane(const std::string& shell, const std::string& more = "") {
  return with_fields(shell, "", more);
}

const std::string kHole = "trims { hole: true circle { center { u: 0.25 v: 0.25 } radius_m: 0.1 } } ";
const std::string kOutline =
    "trims { points { u: 0.05 v: 0.05 } points { u: 0.45 v: 0.05 } points { u: 0.25 v: 0.45 } points { u: 0.05 v: 0.05 "
    "} } ";

}  // namespace

TEST(Trims, ShapeTheShell) {
  const std::string path = own_file("trim_scene.textproto");
  std::ofstream(path) << trimmed_pane(
      "trims { curve { closed: true points { u: 0.1 v: 0.1 } points { u: 0.4 v: 0.1 } points { "
      "u: 0.4 v: 0.4 } points { u: 0.1 v: 0.4 } } } " +
      kHole);
  const auto setup = sunder::shell::build(sunder::scene::load(path, {}));
  std::remove(path.c_str());
  const auto& m = setup.shells[0].model;
  double mass = 0.0;
  for (const double part : m.mass) mass += part;
  // A closed uniform cubic spline around a square of side a = 0.3: its area is 0.6 a^2 to the digits of a fine polygon.
  const double hole = std::numbers::pi * 0.01, found = mass / (2500 * 0.004);
  EXPECT_NEAR(found, m.trim.loops.area(), 1e-12);
  EXPECT_NEAR(
      -m.trim.loops.area() +
          [&] {
            double area = 0.0;
            const auto& p = m.trim.loops.loops()[0].points;
            for (std::size_t k = 0; k + 1 < p.size(); ++k)
              area += 0.5 * (p[k].x() * p[k + 1].y() - p[k].y() * p[k + 1].x());
            return area;
          }(),
      hole, 1e-9);
}

TEST(Trims, ThatAreOpenAreRefused) {
  expect_refusal(
      trimmed_pane("trims { points { u: 0.1 v: 0.1 } points { u: 0.4 v: 0.1 } points { u: 0.2 v: 0.4 } points { u: "
                   "0.1 v: 0.11 } }"),
      "shells[0].trims[0].points[3]", {":10:", "it is open", "end it with its first point"});
  expect_refusal(
      trimmed_pane("trims { curve { points { u: 0.1 v: 0.1 } points { u: 0.4 v: 0.1 } points { u: 0.4 v: 0.4 } "
                   "points { u: 0.1 v: 0.4 } } }"),
      "shells[0].trims[0].curve.closed", {"give closed: true"});
  expect_refusal(trimmed_pane("trims { points { u: 0.1 v: 0.1 } points { u: 0.4 v: 0.1 } points { u: 0.1 v: 0.1 } }"),
                 "shells[0].trims[0].points", {"has 3 points", "three corners"});
  expect_refusal(trimmed_pane("trims { hole: true }"), "shells[0].trims[0]", {"has no shape"});
}

TEST(Trims, ThatMeetThemselvesOrEachOtherAreRefused) {
  expect_refusal(
      trimmed_pane("trims { points { u: 0.1 v: 0.1 } points { u: 0.4 v: 0.4 } points { u: 0.4 v: 0.1 } points { u: "
                   "0.1 v: 0.4 } points { u: 0.1 v: 0.1 } }"),
      "shells[0].trims[0]", {"meets itself at (0.25, 0.25)"});
  expect_refusal(trimmed_pane(kHole + "trims { hole: true circle { center { u: 0.35 v: 0.25 } radius_m: 0.05 } }"),
                 "shells[0].trims[1]", {"meets trims[0]", "join them to one"});
  expect_refusal(trimmed_pane(kHole + "trims { hole: true circle { center { u: 0.25 v: 0.25 } radius_m: 0.05 } }"),
                 "shells[0].trims[1]", {"one in the other", "leave the inner one out"});
  expect_refusal(trimmed_pane(kOutline + "trims { hole: true circle { center { u: 0.42 v: 0.42 } radius_m: 0.05 } }"),
                 "shells[0].trims[1]", {"outside of the outline"});
  expect_refusal(trimmed_pane(kOutline + "trims { circle { center { u: 0.25 v: 0.2 } radius_m: 0.05 } }"),
                 "shells[0].trims[1]", {"second outline", "two shells"});
}

TEST(Trims, ThatLeaveThePatchOrAreTooSmallAreRefused) {
  expect_refusal(trimmed_pane("trims { circle { center { u: 0.25 v: 0.25 } radius_m: 0.3 } }"),
                 "shells[0].trims[0].circle", {"outside the patch", "from 0 to 0.5 along u"});
  expect_refusal(trimmed_pane("trims { hole: true circle { center { u: 0.25 v: 0.25 } radius_m: 0.01 } }"),
                 "shells[0].trims[0].circle.radius_m", {"half a spacing", "more elements"});
  expect_refusal(
      trimmed_pane("trims { points { u: 0.1 v: 0.1 } points { u: 0.11 v: 0.1 } points { u: 0.1 v: 0.11 } points { "
                   "u: 0.1 v: 0.1 } }"),
      "shells[0].trims[0]", {"quarter of an element"});
  expect_refusal(
      trimmed_pane("trims { points { u: 0.1 v: 0.25 } points { u: 0.4 v: 0.25 } points { u: 0.4 v: 0.254 } points { "
                   "u: 0.1 v: 0.254 } points { u: 0.1 v: 0.25 } }"),
      "shells[0].trims", {"too narrow", "more elements"});
}

TEST(Trims, WhatTheyCutAwayHoldsNothing) {
  expect_refusal(trimmed_pane(kOutline + "supports { edges: U_MAX kind: CLAMPED }"), "shells[0].trims",
                 {"support_0_u_max", "no control point"});
  expect_refusal(trimmed_pane(kHole + "loads { point { at { u: 0.25 v: 0.25 } force { z: 1 } } }"), "shells[0].trims",
                 {"(0.25, 0.25)", "outside the trims"});
  expect_refusal(trimmed_pane(kHole, "output { probes { name: \"middle\" shell: \"pane\" at { u: 0.25 v: 0.25 } } }\n"),
                 "output.probes[0].at", {"outside the trims of shell 'pane'"});
}

TEST(Trims, ExcludeWhatNeedsAWholePatch) {
  expect_refusal(trimmed_pane(kHole, "fracture { mode: DAMAGE }\n"), "shells[0].trims", {"DAMAGE", "TIPS"});
  expect_refusal(trimmed_pane(kHole, "transfer { kind: APIC }\n"), "shells[0].trims", {"transfer"});
  expect_refusal(trimmed_pane(kHole + "interlayer { material: \"film\" thickness_m: 0.001 }",
                              "materials { name: \"film\" density: 1100 youngs_modulus: 1e8 poisson_ratio: 0.4 }\n"),
                 "shells[0].trims", {"interlayer"});
}
