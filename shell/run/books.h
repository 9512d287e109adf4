#pragma once
// The energy of a whole run, and what of it is missing.
#include <string>
#include <vector>

#include "shell/run/simulation.h"

namespace sunder::shell {

/// Energies of a run [J]; plain numbers, so that a checkpoint keeps them as they lie.
struct Books {
  EnergyBook frozen{};             // of the shells, kept from the moment in which they are frozen
  double scale = 0.0;              // the most energy there was at once
  double reference = 0.0;          // at the start
  double residual = 0.0;           // that the books miss, as a share of `scale` [-]
  double contact_taken = 0.0;      // by contact, at most so far
  double contact_given = 0.0;      // back by contact after that, at most; contact can only take
  double frozen_kinetic = 0.0;     // of the shell, as it was frozen
  double frozen_length = 0.0;      // of its cracks [m]
  double frozen_resistance = 0.0;  // of its cracks

  /// Of all shells, frozen or not.
  EnergyBook sum(Simulation& simulation) const;
  double crack_length(Simulation& simulation) const;  // [m]
  /// Energy that the cracks which ran by themselves should take, by fracture energy and area.
  double crack_resistance(Simulation& simulation) const;
  /// At the start: `energy` is that of shells and bodies.
  void open(Simulation& simulation, double energy);
  /// After a window: `energy` is the present and the booked energy together.
  void close(Simulation& simulation, double energy);
  /// Throws Error (unstable) where the energy of shells and bodies has changed by more than they could have.
  void check_stable(Simulation& simulation, double energy, std::int64_t window) const;
};

/// Throws Error (unstable).
[[noreturn]] void unstable(double energy, std::int64_t window);

/// Points that a user should know before trusting the run, a sentence each. `coupling_residual` is the sum of the
/// windows' energy residuals [J].
std::vector<std::string> warnings(const Books& books, Simulation& simulation, double coupling_residual);

}  // namespace sunder::shell
