#pragma once
// Equilibrium of a shell under loads.
#include <functional>

#include "shell/solver/state.h"

namespace sunder::shell {

/// Limits of the search for equilibrium.
struct RelaxationRules {
  double tolerance = 1e-6;  // residual, as a share of the forces that it balances
  std::int64_t most_steps = 2'000'000;
  int most_newton = 60;         // Newton steps before dynamic relaxation; 0: none
  Vec3 gravity = Vec3::Zero();  // [m/s^2]
  int threads = 1;
  std::function<void()> look;  // called now and then; an exception from it ends the search
};

/// The result of a search for equilibrium.
struct RelaxationResult {
  bool converged = false;  // also false where round-off keeps the residual above the tolerance
  double residual = 0.0;   // norm of unbalanced forces, divided by that of loads or reactions
  std::int64_t steps = 0;  // of dynamic relaxation
  int newton = 0;
};

/// Moves the shell from its present positions to equilibrium under loads at state.motion.time, gravity and supports
/// (driven ones at their place at that time). It ends when the residual is below the tolerance, or when a Newton step
/// could do less work than tolerance squared times the loads' work. Velocities are zero afterwards. An uncracked shell
/// first tries Newton steps. Where they fail, and for cracked shells, dynamic relaxation with kinetic damping follows
/// (Cundall 1976): fictitious masses give every control point a similar time step, and all velocities are set to zero
/// after each peak of kinetic energy.
RelaxationResult relax(const ShellModel& model, ShellState& state, const RelaxationRules& rules);

}  // namespace sunder::shell
