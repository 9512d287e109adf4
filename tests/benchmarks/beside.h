#pragma once
// What two threads gain alone, and beside another program that keeps a processor busy.
#include "tests/benchmarks/two_processes.h"

namespace sunder::bench {

/// Substeps with two threads over those with one, alone and beside a process that does nothing but count.
ProcessBenchmark beside_benchmark();

}  // namespace sunder::bench
