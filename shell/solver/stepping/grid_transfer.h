#pragma once
// Transfer of velocities through the background grid, as in the paper.
#include "shell/solver/state.h"

namespace sunder::shell {

/// The way that velocities take from substep to substep.
struct TransferRules {
  Transfer kind = Transfer::kDirect;
  double spacing = 0.0;  // of the grid [m]
  // True: forces on held control points go to the grid too and reach free points beside them, as in a grid that does
  // not know supports. False: supports bear these forces.
  bool leaky = false;
};

/// Passes velocities through the background grid and applies supports. Call it after contact, in place of `constrain`;
/// `kick` has stored the velocities before it. `dt` is the substep [s]. The loss of energy is booked.
void through_grid(const ShellModel& model, ShellState& state, const TransferRules& rules, double dt, int threads);

}  // namespace sunder::shell
