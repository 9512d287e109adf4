#pragma once
// Weights of the background grid: quadratic B-splines, three nodes a direction.
#include <array>
#include <cmath>

namespace sunder::shell {

constexpr int kNodes = 3;  // nodes per direction in the support of a particle

/// Lowest node and weights of a particle at `x` (in grid spacings). Node k lies at base + k. The weights sum to one and
/// reproduce x.
struct Weights {
  int base;
  std::array<double, kNodes> w;
};
inline Weights grid_weights(double x) {
  const double lowest = std::floor(x - 0.5), f = x - lowest;  // f from 1/2 to 3/2
  return {static_cast<int>(lowest),
          {0.5 * (1.5 - f) * (1.5 - f), 0.75 - (f - 1.0) * (f - 1.0), 0.5 * (f - 0.5) * (f - 0.5)}};
}

}  // namespace sunder::shell
