#pragma once

#include <string>
#include <vector>

#include "shell/solver/state.h"

namespace sunder::shell {

/// The energy books of a run [J], from which warnings are made at its end.
struct Audit {
  EnergyBook book;
  double scale = 0.0;     // largest energy at any time; 0: no energy, so nothing to judge
  double residual = 0.0;  // energy that the books miss [share of `scale`]
  double returned = 0.0;  // largest fall of the contact book below its maximum so far: energy that contact has returned
  double coupling = 0.0;  // uncertain because the shell pushes bodies that the engine holds
  double frozen = 0.0;    // kinetic energy of the shell when it was frozen
  bool grid_transfer = false;  // velocities pass through a background grid
  bool keeps_damage = false;   // damage does not heal
};

/// Returns the energy [J] that cracks should take by the material's fracture energy and their area. Only cracks that
/// ran by themselves count: prescribed cuts, cracks from damage and the first spacing beyond a seam do not. The
/// fracture energy is scaled by the square of the local strength factor. Only lengths within the patch count.
double crack_resistance(const ShellModel& model, const ShellState& state);

/// Returns warnings about the energies of a run, one sentence each; empty where there are none.
std::vector<std::string> audit_warnings(const Audit& audit);

}  // namespace sunder::shell
