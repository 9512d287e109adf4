#pragma once
// The command that finds the modes of vibration of a scene's shells.
#include <functional>
#include <string>

#include "shell/io/build.h"

namespace sunder::shell {

/// What modes are asked for.
struct ModesOptions {
  int count = 10;          // lowest modes over all shells; 0: none
  double amplitude = 0.1;  // largest displacement that is drawn, over the size of all shells [-]
  std::string out, scene_hash;
  std::string scene_text;  // with settings, for the copy in `out`; empty: no copy
  int threads = 1;
};

/// Finds the lowest modes of all shells about their start or, with equilibrium, about their last equilibrium. Writes
/// modes.json, a frame of each mode (frames.pvd; the time is the number of the mode) and one period of each mode as
/// frames of its own folder (mode_01/frames.pvd). Prints a table. Throws Error (bad_input, modes, equilibrium,
/// bad_output).
void write_modes(RunSetup setup, const ModesOptions& options, const std::function<void()>& look);

}  // namespace sunder::shell
