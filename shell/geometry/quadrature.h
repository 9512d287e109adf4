#pragma once
// Gauss-Legendre rules on [-1, 1].
#include <vector>

namespace sunder::shell {

struct GaussRule {
  std::vector<double> point, weight;  // weights sum to 2
};

/// 1 to 16 points; exact for polynomials of degree 2n - 1. Nodes by Newton on P_n, made once.
const GaussRule& gauss_rule(int points);

}  // namespace sunder::shell
