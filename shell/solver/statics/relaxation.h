#pragma once
// Equilibrium of a shell under loads.
#include <functional>
#include <vector>

#include "shell/solver/statics/joined.h"

namespace sunder::shell {

/// Limits of the search for equilibrium.
struct RelaxationRules {
  double tolerance = 1e-6;  // residual, as a share of the forces that it balances
  std::int64_t most_steps = 2'000'000;
  int most_newton = 60;         // Newton steps before dynamic relaxation; 0: none
  Vec3 gravity = Vec3::Zero();  // on one shell alone [m/s^2]
  int threads = 1;
  std::function<void()> look;  // called now and then; an exception from it ends the search
};

/// The result of a search for equilibrium.
struct RelaxationResult {
  enum class Stable : std::uint8_t { kUnknown, kYes, kNo };
  bool converged = false;
  double residual = 0.0;   // norm of unbalanced forces, divided by that of loads or reactions
  bool round_off = false;  // the residual is above the tolerance, and as low as round-off of the positions allows
  Stable stable = Stable::kUnknown;  // by the eigenvalues of the last tangent stiffness
  int newton = 0;                    // Newton steps
  int load_steps = 0;                // steps in which loads were brought up; 0: all at once
  double share = 0.0;                // of the loads, at the last equilibrium that was found; 1: converged
  std::int64_t steps = 0;            // of dynamic relaxation

  /// Returns "newton", "load_steps" or "relaxation", or "" where no equilibrium was found.
  const char* found_by() const {
    return !converged ? "" : steps > 0 ? "relaxation" : load_steps ? "load_steps" : "newton";
  }
};

/// Moves the shell from its present positions to equilibrium under loads at state.motion.time, gravity and supports
/// (driven ones at their place at that time). It ends when the residual is below the tolerance or is round-off, or when
/// a Newton step could do less work than tolerance squared times the loads' work. Velocities are zero afterwards. Three
/// ways are tried one after another:
/// 1. Newton steps under all loads. Only for an uncracked shell.
/// 2. Newton steps while the loads are brought up, in steps that become shorter where Newton fails. Only for an
///    uncracked shell. It fails where the shell snaps.
/// 3. Dynamic relaxation with kinetic damping (Cundall 1976) under all loads, from the last equilibrium: fictitious
///    masses give every control point a similar time step, and all velocities are set to zero after each peak of
///    kinetic energy. It ends by Newton steps where they converge. A shell that moves away as a whole ends it.
/// Where none is found the shell is left in the last equilibrium, at result.share of the way; at 0 where it was.
RelaxationResult relax(const ShellModel& model, ShellState& state, const RelaxationRules& rules);

/// Forces of seams on the control points of each joined shell, [shell][3][component stride] [N]. Those on dependent
/// control points take away what others bear.
using SeamForces = std::vector<std::vector<double>>;

/// The same for shells that seams join: all are in equilibrium together, at joined.gravity. Dependent control points
/// follow, and constraints of seams hold (Newton's method with multipliers). `of_seams` receives the forces of seams,
/// where it is not null.
RelaxationResult relax(const JoinedShells& joined, const RelaxationRules& rules, SeamForces* of_seams = nullptr);

}  // namespace sunder::shell
