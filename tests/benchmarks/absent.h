#pragma once
// What a scene does not ask for costs nothing: a run beside the bare loop of a substep, and with models that are
// there and have nothing to do.
#include "tests/benchmarks/two_processes.h"

namespace sunder::bench {

/// Its numbers: `absent_time_ratio` and `absent_memory_ratio` of a run of an elastic sheet over the bare loop on the
/// same sheet, `absent_allocations_per_substep`; and the same of runs with one idle model each,
/// `absent_but_idle_NAME_...`.
ProcessBenchmark absent_benchmark();

}  // namespace sunder::bench
