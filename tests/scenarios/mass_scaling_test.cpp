// A sheet whose narrow elements get mass, in a run: the step that is told, and the period that is told.
#include <cmath>

#include <gtest/gtest.h>

#include "shell/run/simulation.h"
#include "shell/solver/forces.h"
#include "shell/solver/statics/modes.h"
#include "tests/coupler/narrow_sheet.h"
#include "tests/coupler/small_scene.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

/// Starts in the first mode, and returns the period by the passages of the middle of the free end through zero [s].
double measured_period(RunSetup& setup) {
  Simulation simulation(setup, 1);
  simulation.prepare();
  simulation.start_shells([] {});
  ShellPart& part = simulation.state.shells[0];
  ShellState& s = *part.state;
  const ShellModel& m = part.model();
  const ModeSet set = vibration_modes(m, s, 1, [&] { compute_forces(m, s, false, 0.0, 1); });
  const Mode& mode = set.modes[0];
  for (std::size_t k = 0; k < s.motion.v.size(); ++k)  // a hundredth of the thickness: linear to 1e-4
    s.motion.v[k] = 2.0 * std::numbers::pi * mode.in_run * 0.01 * m.thickness * mode.shape[k];
  const double dt = setup.safety * part.initial_step;
  const std::size_t tip = 2 * static_cast<std::size_t>(m.tables.component_stride) +
                          m.tables.slot(m.tables.columns * (m.tables.rows / 2) + m.tables.columns - 1);
  std::vector<double> passages;
  double before = 0.0, last = 0.0;
  for (int n = 1; passages.size() < 3 && n * dt < 4.0 / mode.in_run; ++n) {
    simulation.take_substeps(1, dt, last, Clock{}, [] {}), last = dt;
    const double z = s.motion.x[tip];
    if (n > 1 && before * z < 0.0) passages.push_back((n - 1 + before / (before - z)) * dt);
    before = z;
  }
  EXPECT_EQ(passages.size(), 3u);
  return passages.size() == 3 ? passages[2] - passages[0] : 0.0;
}

RunSetup sheet(const std::string& scaling) {
  return small_scene::built(narrow_sheet::scene(scaling, 10, 2), {"shells[sheet].thickness_m=0.05", "window_s=1e-2"});
}

}  // namespace

TEST(MassScaling, LeavesASceneAloneThatDoesNotAskForIt) {
  const RunSetup setup = sheet("");
  EXPECT_FALSE(setup.mass_scaling.has_value());
  EXPECT_TRUE(setup.shells[0].model.mass_factor_of_slot.empty());
}

TEST(MassScaling, ARunTakesTheStepAndHasTheMassThatAreTold) {
  RunSetup without = sheet(""), with = sheet("factor: 2 most_added: 1 most_error: 0.5");
  const MassScaling told = *with.mass_scaling;
  double mass[2] = {0.0, 0.0}, step[2] = {0.0, 0.0};
  int at = 0;
  for (RunSetup* setup : {&without, &with}) {
    Simulation simulation(*setup, 1);
    simulation.prepare();
    simulation.start_shells([] {});
    step[at] = simulation.state.shells[0].initial_step;
    for (const double m : simulation.state.shells[0].state->motion.mass) mass[at] += m;
    ++at;
  }
  EXPECT_EQ(step[0], told.step_before);
  EXPECT_EQ(step[1], told.step_after);
  EXPECT_GE(step[1], 2.0 * step[0]);
  EXPECT_NEAR(mass[1] - mass[0], told.added, 1e-12 * mass[0]);
  EXPECT_NEAR(told.share, told.added / mass[0], 1e-12);
}

// Central differences make a period shorter by (omega dt)^2 / 24, below 1e-6 here; straight lines between substeps find
// its passages better than that. The amplitude adds 1e-4.
TEST(MassScaling, TheErrorThatIsToldIsThatOfThePeriodOfARun) {
  RunSetup without = sheet(""), with = sheet("factor: 2 most_added: 1 most_error: 0.5");
  const double before = measured_period(without), after = measured_period(with);
  const MassScaling::Lowered& first = with.mass_scaling->modes[0];
  EXPECT_GT(first.error(), 0.005);
  EXPECT_NEAR(1.0 - before / after, first.error(), 2e-4);
  EXPECT_NEAR(after * first.after, 1.0, 2e-4);
}
