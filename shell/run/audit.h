#pragma once

#include <string>
#include <vector>

#include "shell/solver/state.h"

namespace sunder::shell {

/// What a run has booked, to be judged at its end [J].
struct Audit {
  EnergyBook book;
  double scale = 0.0;          // the most energy there was; 0: none, so nothing to be judged
  double residual = 0.0;       // of the books, a share of `scale`
  double given = 0.0;          // by contact: the most that its book has fallen below what it had taken by then
  double coupling = 0.0;       // uncertain by windows in which the shell pushes what the engine holds
  double frozen = 0.0;         // kinetic, of the shell when it was frozen
  bool grid_transfer = false;  // velocities go through a background grid
  bool keeps_damage = false;   // which does not heal
};

/// What the cracks that ran by themselves should take, by the material's fracture energy and their area in the shell
/// [J]; scaled by the square of the strength factor where they run. Cuts, what damage makes and the first spacing
/// beyond a seam are left out.
double crack_resistance(const ShellModel& model, const ShellState& state);

/// What a user should know of these energies before trusting the run, a sentence each; empty: nothing.
std::vector<std::string> doubts(const Audit& audit);

}  // namespace sunder::shell
