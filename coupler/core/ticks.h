#pragma once
// Time as a whole number of ticks. Times are products, never running sums, so they do not drift.
#include <cmath>
#include <cstdint>

namespace sunder {

/// Converts ticks to seconds and back.
struct Ticks {
  double length = 1.0;  // [s]

  /// Start of a tick, measured from the start of the run [s]; one rounding.
  double time(std::int64_t tick) const { return static_cast<double>(tick) * length; }
  /// The tick whose start is nearest to a time [s].
  std::int64_t nearest(double time) const { return std::llround(time / length); }
  /// Length of a substep [s] in a window of `ticks` ticks and n substeps.
  double substep(std::int64_t ticks, int n) const { return time(ticks) / n; }
};

}  // namespace sunder
