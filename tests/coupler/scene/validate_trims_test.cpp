// Trim loops of a scene: refusals with field and remedy, and the built model.
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

TEST(Trims, WithoutAShapeOrOpenAreRefused) {
  expect_refusal(
      trimmed_pane("trims { curve { points { u: 0.1 v: 0.1 } points { u: 0.4 v: 0.1 } points { u: 0.4 v: 0.4 } "
                   "points { u: 0.1 v: 0.4 } } }"),
      "shells[0].trims[0].curve.closed", {"give closed: true"});
  expect_refusal(trimmed_pane("trims { hole: true }"), "shells[0].trims[0]", {"has no shape"});
}

TEST(Trims, ThatLeaveTooNarrowAStripAreRefused) {
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
  expect_refusal(trimmed_pane(kHole, "fracture { mode: DAMAGE }\n"), "shells[0].trims",
                 {"DAMAGE", "beyond a loop", "TIPS"});
  expect_refusal(trimmed_pane(kHole + "fibres { compression_modulus: 1e5 shear_modulus: 1e5 }",
                              "contacts { first: \"pane\" second: \"pane\" }\n"),
                 "shells[0].trims", {"fibres", "stable step"});
  expect_refusal(trimmed_pane(kHole, "transfer { kind: APIC }\n"), "shells[0].trims", {"transfer", "by its mass"});
}
