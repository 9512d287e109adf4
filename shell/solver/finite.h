#pragma once
// Checks that positions and velocities are numbers. What is unstable is found within a few substeps, with its name and
// place.
#include <cstdint>
#include <string>
#include <vector>

#include "shell/contact/proxy.h"
#include "shell/solver/state.h"

namespace sunder::shell {

/// How long substeps are: `safety` times the stable step, or `time_step` [s] where that is above 0.
struct StepRule {
  double safety, time_step;
};
/// Returns what to do about something unstable, for messages.
std::string unstable_remedy(const StepRule& rule);

constexpr int kFiniteInterval = 8;  // substeps between two checks

/// Throws Error (unstable) where a control point's position or velocity is not finite. The message names the shell, the
/// place, the time [s] and a remedy.
void check_finite(const ShellModel& model, const ShellState& state, double time, const StepRule& rule);
/// Throws Error (unstable) where a body's position or velocity is not finite.
void check_finite(const std::vector<Proxy>& bodies, std::int64_t window, const StepRule& rule);

}  // namespace sunder::shell
