#pragma once
// Smooth curves through values at given times: cubic Hermite pieces.
#include <vector>

#include "coupler/core/vec.h"

namespace sunder {

/// Slope of a curve at a key, from the slopes of the straight lines before and after it, which last `h0` and `h1` [s].
/// It is that of the parabola through the three keys, shortened so that the curve does not overshoot a key. It is zero
/// where the two lines turn back.
Vec3 smooth_slope(const Vec3& before, const Vec3& after, double h0, double h1);

/// Slopes at all keys. The curve is at rest before its first key and after its last, so its slope is zero there.
std::vector<Vec3> smooth_slopes(const std::vector<double>& times, const std::vector<Vec3>& values);

/// The value at a time is a x[key] + b slope[key] + c x[key + 1] + d slope[key + 1].
struct HermiteWeights {
  int key = 0;
  double a = 1.0, b = 0.0, c = 0.0, d = 0.0;
};
/// Weights at time t [s]. Before the first key and after the last the curve stays. `times` rise.
HermiteWeights hermite_weights(const std::vector<double>& times, double t);

}  // namespace sunder
