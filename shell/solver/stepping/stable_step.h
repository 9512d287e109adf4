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
/// [-]: the stable step is measured again where two neighbouring control points have come closer by this factor since
/// the last time. A neo-Hookean layer that cannot widen has the stiffness (1 + 3/l^4) mu at the stretch l. Within such
/// a factor it grows by 1.23 at most, so the step stays above 0.9 of the last one. By default substeps take 0.8, which
/// leaves a tenth for what a measurement is off by.
constexpr double kCloser = 0.95;
constexpr int kSqueezedIterations = 20;  // a squeezed region is larger than that near a crack

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
