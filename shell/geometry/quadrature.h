#pragma once
// Gauss-Legendre rules on [-1, 1].
#include <vector>

namespace sunder::shell {

struct GaussRule {
  std::vector<double> point, weight;  // weights sum to 2
};

/// Returns the Gauss-Legendre rule of 1 to 16 points, exact for polynomials of degree 2n - 1. Nodes come from Newton's
/// method on P_n and are computed once. Throws Error for another number of points.
const GaussRule& gauss_rule(int points);

}  // namespace sunder::shell
