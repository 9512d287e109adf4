// Runs in which no body meets a shell are told, and no others.
#include <string>

#include <gtest/gtest.h>

#include "shell/run/nearness.h"
#include "tests/shell/free_run.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// The sentence that a run tells; empty: none. `ball`: pose and motion of the ball in the scene of FreeRun.
std::string said(const std::string& ball, double until = 0.0, const std::string& more = "") {
  FreeRun run;
  const std::string given = "  pose { position { x: 1 z: 0.5 } }\n  twist { linear { x: 3 } }\n";
  run.text.replace(run.text.find(given), given.size(), ball);
  run.text += more;
  run.options.until = until;
  run.execute();
  std::string found;
  const auto summary = run.summary();  // outlives the loop
  for (const std::string told : summary["warnings"])
    if (told.find("has touched a shell") != std::string::npos) found += told;
  return found;
}

const std::string kAway = "  pose { position { x: 1 z: 0.5 } }\n  twist { linear { x: 3 } }\n";

}  // namespace

// The plate ends at x = 0.1 m. The first look is after a window, in which the ball flies on by 0.3 mm:
// sqrt(0.9^2 + 0.5^2) m less its radius and half the thickness, to two digits.
TEST(Nearness, ARunWithoutContactNamesBodyShellDistanceAndTime) {
  EXPECT_EQ(said(kAway),
            "no moving body has touched a shell in 0.001 s: 'ball' was nearest, 1 m from shell 'pane' at 0.0001 s, as "
            "far as looks from time to time tell; look at its place and velocity, or give a later end_time_s");
}

// The last state counts: the ball comes by 4 mm of the 14 mm between the faces, the plate by less than its 2 mm.
TEST(Nearness, TheEndOfTheRunCounts) {
  const std::string told = said("  pose { position { x: 0.02 z: 0.036 } }\n  twist { linear { z: -4 } }\n");
  EXPECT_NE(told.find(" m from shell 'pane' at 0.001 s"), std::string::npos) << told;
  const std::size_t at = told.find("was nearest, ");
  ASSERT_NE(at, std::string::npos) << told;
  const double gap = std::stod(told.substr(at + 13));
  EXPECT_GE(gap, 0.008);
  EXPECT_LE(gap, 0.0101);  // it is rounded to two digits, and gravity adds 5 um
}

TEST(Nearness, ARunWithContactSaysNothing) {
  EXPECT_EQ(said("  pose { position { x: 0.02 z: 0.024 } }\n  twist { linear { z: -4 } }\n"), "");
}

TEST(Nearness, ARunThatEndsEarlySaysForHowLong) {
  EXPECT_EQ(said(kAway, 5e-4).find("no moving body has touched a shell in 0.0005 s: "), 0u);
}

// Nothing was touched before the shell froze, so it never can break.
TEST(Nearness, AShellThatFrozeUntouchedIsTold) {
  const std::string told = said(kAway, 0.0, "fracture { latest_freeze_s: 5e-4 }\n");
  EXPECT_EQ(
      told.find("no moving body has touched a shell in 0.0005 s, when the shells were frozen: 'ball' was nearest"), 0u)
      << told;
  EXPECT_NE(told.find("let the shells be frozen later (fracture { latest_freeze_s })"), std::string::npos) << told;
  // Frozen since a cut plate is quiet: another field decides when.
  FreeRun run;
  const RunSetup setup = build(run.loaded());
  Nearness near;
  near.body = near.shell = 0, near.gap = 1.0, near.time = 1e-4;
  EXPECT_NE(apart_warning(setup, near, 5e-4, "cracks grew by 0 of their length within 1e-4 s").find("{ quiet_time_s }"),
            std::string::npos);
  EXPECT_EQ(said("  pose { position { x: 0.02 z: 0.024 } }\n  twist { linear { z: -4 } }\n", 0.0,
                 "fracture { latest_freeze_s: 8e-4 }\n"),
            "");
}

TEST(Nearness, ASceneWithoutAMovingBodySaysNothing) {
  EXPECT_EQ(said("  pose { position { x: 1 z: 0.5 } }\n  is_static: true\n"), "");
}

// A moving body between two others, none of which is nearer than it: only what moves is told.
TEST(Nearness, AStaticBodyIsNotTold) {
  const std::string told =
      said(kAway, 0.0,
           "bodies { name: \"post\" is_static: true sphere { radius_m: 0.02 } pose { position { x: "
           "0.3 } } }\n");
  EXPECT_NE(told.find("'ball' was nearest"), std::string::npos) << told;
}
