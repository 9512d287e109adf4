#include <gtest/gtest.h>

#include "shell/solver/state.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(StableStep, OfAPlateIsThatOfItsStiffestMembraneMode) {
  const Support all{kUMin | kUMax | kVMin | kVMax, true};
  const ShellModel m =
      make_shell("p", plate(0.5, 0.5, 40, 40, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {all});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  // quadratic B-splines with lumped mass: omega^2 = 3/2 (c/h)^2 for an endless row, so 1.633 h/c
  EXPECT_NEAR(stable_step(m, s, 200, 1, false) * m.wave_speed() / m.spacing, 1.633, 0.02);
  EXPECT_NEAR(stable_step(m, s, 200, 1, true) * m.wave_speed() / m.spacing, 0.82, 0.03);
}
