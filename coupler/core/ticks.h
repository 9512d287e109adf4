#pragma once
// Time is whole ticks. Beyond a window no length of time is summed up, so none drifts.
#include <cmath>
#include <cstdint>

namespace sunder {

struct Ticks {
  double length = 1.0;  // [s]

  /// When a tick begins, from the start of the run [s]: exact but for one rounding.
  double time(std::int64_t tick) const { return static_cast<double>(tick) * length; }
  std::int64_t nearest(double time) const { return std::llround(time / length); }
  /// A substep of a window of `ticks` that takes n of them [s].
  double substep(std::int64_t ticks, int n) const { return time(ticks) / n; }
};

}  // namespace sunder
