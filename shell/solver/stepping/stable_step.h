#pragma once
// The stable length of a substep.
#include <vector>

#include "shell/solver/joining/stitching.h"

namespace sunder::shell {

constexpr int kStepIterations = 60;     // exact to round-off, also for patches of 200 elements a side
constexpr int kLocalIterations = 9;     // near a new crack: mostly exact to 5 %
constexpr int kJoinedIterations = 120;  // for shells that are joined
/// Multiple of a step that is above the step when rounded to three digits: for messages that name a least value.
constexpr double kEnough = 1.006;

/// Returns the stable step [s] at the present positions: 2 / sqrt(lambda_max of M^-1 K). It uses the method of Lanczos;
/// for shells that yield or are damaged, twice as many power iterations. Both approach it from above. The first guess
/// is noise on control points within reach of `around` (everywhere where that is empty). A mode that a new crack or a
/// smaller mass makes is local, and an older mode would not contain it. `as_if_free` leaves supports out. A free edge
/// halves the stable step of a clamped plate, and every crack makes free edges. So a shell that can crack is treated as
/// free from the start.
double stable_step(const ShellModel& model, ShellState& state, int iterations, int threads, bool as_if_free,
                   const std::vector<Vec2>& around = {});

/// The same for shells that are joined, by power iteration; `as_if_free` is given for each. In other shells a control
/// point that a support holds along some axes does not move along them, and bears what ties ask of it there.
double stable_step(const std::vector<ShellRef>& shells, Stitching& stitching, int iterations, int threads,
                   const std::vector<char>& as_if_free);

/// Returns the initial stable steps [s] of joined shells whose own steps are `alone`. Joined shells share mass and
/// stiffness, so together they are at least as stable as the least stable one alone; mostly more, since joined edges
/// are not free. A shell that is taken `as_if_free` keeps its own step where that is longer.
std::vector<double> joined_steps(const std::vector<ShellRef>& shells, Stitching& stitching,
                                 const std::vector<double>& alone, const std::vector<char>& as_if_free, int iterations,
                                 int threads);

}  // namespace sunder::shell
