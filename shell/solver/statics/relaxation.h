#pragma once
// Quasi-static answers: equilibrium under loads.
#include <functional>

#include "shell/solver/state.h"

namespace sunder::shell {

struct RelaxationRules {
  double tolerance = 1e-6;  // residual over the forces that it balances
  std::int64_t most_steps = 2'000'000;
  int most_newton = 60;         // Newton steps before dynamic relaxation takes over; 0: none
  Vec3 gravity = Vec3::Zero();  // [m/s^2]
  int threads = 1;
  std::function<void()> look;  // called now and then; what it throws ends the search
};

struct RelaxationResult {
  bool converged = false;  // false also where round-off keeps the residual above the tolerance
  double residual = 0.0;   // norm of the forces that nothing balances over that of loads, or of reactions
  std::int64_t steps = 0;  // of dynamic relaxation
  int newton = 0;
};

/// Moves the shell from where it stands to equilibrium under its loads at state.motion.time, gravity and supports
/// (driven ones at their place of that time), until the residual is below the tolerance, or what it could still do on a
/// Newton step is below the tolerance squared of the loads' work. Velocities are zero afterwards. An uncracked shell
/// first tries Newton steps. Where they do not get there, and for cracked shells, dynamic relaxation with kinetic
/// damping: the shell moves freely with fictitious masses, which give every control point a like time step, and all
/// velocities are taken out whenever the kinetic energy has passed a peak (Cundall 1976).
RelaxationResult relax(const ShellModel& model, ShellState& state, const RelaxationRules& rules);

}  // namespace sunder::shell
