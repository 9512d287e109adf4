#pragma once
// The energy of a whole run, and the part of it that the books miss.
#include <string>
#include <vector>

#include "shell/run/audit.h"
#include "shell/run/simulation.h"

namespace sunder::shell {

/// Energies of a run [J]. All members are plain numbers, so a checkpoint stores them as bytes.
struct Books {
  EnergyBook frozen{};           // books of the shells, taken when they are frozen
  double scale = 0.0;            // largest kinetic plus elastic energy so far
  double reference = 0.0;        // total energy at the start
  double residual = 0.0;         // energy that the books miss, as a share of `scale` [-]
  double gap = 0.0;              // energy that the books miss now; positive: energy from nowhere
  double largest_gap = 0.0;      // the same, where it was largest
  double window_gap = 0.0;       // its largest change in one window
  double window_gap_time = 0.0;  // end of that window [s]
  // Most energy of what deforms so far: kinetic and elastic energy of shells and soft bodies, and what their books have
  // taken. A window is judged by it: a body may carry far more energy past a shell than ever meets it.
  double deforming = 0.0;
  double contact_taken = 0.0;     // largest value of the contact book so far
  double contact_returned = 0.0;  // largest fall below it; contact can only take energy
  double engine_taken = 0.0;      // the same of contacts and joints between bodies
  double engine_returned = 0.0;
  double frozen_kinetic = 0.0;    // kinetic energy of the shells when they were frozen
  double frozen_length = 0.0;     // length of their cracks then [m]
  CrackSurface frozen_surface{};  // surface of their cracks then
  // The body of the scene that was beside them then and moved with most energy, that energy [J], and the time [s]; -1:
  // none.
  int frozen_beside = -1;
  double frozen_beside_energy = 0.0, frozen_time = 0.0;

  /// Sum of the books of all shells and soft bodies, frozen or not.
  EnergyBook sum(Simulation& simulation) const;
  double crack_length(Simulation& simulation) const;  // [m]
  /// Surface that cracks which ran by themselves have made, of all shells.
  CrackSurface crack_surface(Simulation& simulation) const;
  /// Starts the books. `energy` is the total energy of shells and bodies [J].
  void open(Simulation& simulation, double energy);
  /// Updates the books after a window that ends at `time` [s]. `energy` is the present energy plus all booked energy
  /// [J].
  void close(Simulation& simulation, double energy, double time);
  /// Throws Error (unstable) where the energy [J] has changed by more than the scene can account for.
  void check_stable(Simulation& simulation, double energy, std::int64_t window) const;
};

/// Returns warnings about the run, one sentence each. `coupling_residual` is the sum of the windows' energy residuals
/// [J], `rubble` the share of Gauss points that bear nothing.
std::vector<std::string> warnings(const Books& books, Simulation& simulation, double coupling_residual, double rubble);

}  // namespace sunder::shell
