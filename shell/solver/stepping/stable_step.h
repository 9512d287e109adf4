#pragma once
// How long a substep may be.
#include <vector>

#include "shell/solver/joining/stitching.h"

namespace sunder::shell {

constexpr int kStepIterations = 60;     // to round-off of what matters, for patches of 200 elements a side too
constexpr int kLocalIterations = 9;     // about a new crack: mostly to 5 %
constexpr int kJoinedIterations = 120;  // of shells that hang together

/// Largest stable step [s] about the present positions: 2 / sqrt(lambda_max of M^-1 K) by the method of
/// Lanczos, of shells that yield or are damaged by twice as many power iterations. Both approach it from above. It
/// starts from noise on the control points that lie within reach of `around` (everywhere where that is empty): a mode
/// that a new crack or a lost mass made is local, and a vector kept from before would not contain it. `as_if_free`:
/// supports are left out. A free edge halves the stable step of a clamped plate, and every crack makes free edges, so a
/// shell that can crack is stepped as if it were free from the start.
double stable_step(const ShellModel& model, ShellState& state, int iterations, int threads, bool as_if_free,
                   const std::vector<Vec2>& around = {});

/// The same of shells that hang together, by power iteration; `as_if_free` of each.
double stable_step(const std::vector<ShellRef>& shells, Stitching& stitching, int iterations, int threads,
                   const std::vector<char>& as_if_free);

/// Stable steps [s] at the start of shells that hang together, whose own ones are `alone`. Shells that give their
/// neighbours mass and stiffness are together at least as stable as the least stable of them is alone; mostly more, as
/// edges that are joined are no free ones. One that can crack keeps its own where that is longer.
std::vector<double> joined_steps(const std::vector<ShellRef>& shells, Stitching& stitching,
                                 const std::vector<double>& alone, const std::vector<char>& can_crack, int iterations,
                                 int threads);

}  // namespace sunder::shell
