#pragma once
// Local time steps: how many substeps lie between two force evaluations of a shell. README.md has the equations.
#include <vector>

namespace sunder::shell {

constexpr int kLongestStep = 16;  // [substeps] of one step of a shell, at most
constexpr int kJoinedStep = 2;    // the same of shells that seams join: above it modes of the fast ones resonate

/// What limits the step of a shell.
struct StepLimit {
  double step = 0.0;    // stable step without what seams join to it, with an allowance for cracks to come [s]
  double alone = 0.0;   // the same as measured [s]
  double joined = 0.0;  // stable step as a part of all that seams join, as measured [s]
  double work = 0.0;    // of one force evaluation, in any unit
  int group = 0;        // shells that seams join have one number
  bool may = true;      // false: it evaluates its forces at every substep
};

/// Substeps of a window, and between two force evaluations of each shell.
struct LocalSteps {
  int substeps = 1;
  std::vector<int> every;
};

/// Chooses powers of two with the least work for a window of `window` [s] that needs at least `least` substeps: a step
/// takes at most the share `safety` of the shell's stable one, and the window holds a whole number of each. What a
/// substep does beside forces counts as much as the forces of all shells.
LocalSteps local_steps(const std::vector<StepLimit>& shells, double window, int least, double safety);

}  // namespace sunder::shell
