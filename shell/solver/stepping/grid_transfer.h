#pragma once
// Velocities on their way through the background grid, the paper's transfer.
#include "shell/solver/state.h"

namespace sunder::shell {

/// How velocities move on from substep to substep.
struct TransferRules {
  Transfer kind = Transfer::kDirect;
  double spacing = 0.0;  // of the grid [m]
  // Forces on what supports hold go to the grid too and reach what moves beside it, as where supports are known to no
  // grid node; else supports bear them.
  bool leaky = false;
};

/// Velocities through the background grid, and of what supports hold: after contact, in place of `constrain`, where
/// `kick` was told to keep those before it. What that loses of the energy is booked.
void through_grid(const ShellModel& model, ShellState& state, const TransferRules& rules, double dt, int threads);

}  // namespace sunder::shell
