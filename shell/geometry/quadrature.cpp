#include "shell/geometry/quadrature.h"

#include <cmath>
#include <numbers>

#include "coupler/core/error.h"

namespace sunder::shell {

namespace {

GaussRule make_rule(int n) {
  GaussRule rule;
  for (int i = 0; i < n; ++i) {
    double x = -std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5)), slope = 1.0;
    for (int iteration = 0; iteration < 100; ++iteration) {
      double p0 = 1.0, p1 = x;
      for (int k = 2; k <= n; ++k) {
        const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
        p0 = p1, p1 = p2;
      }
      slope = n * (x * p1 - p0) / (x * x - 1.0);
      const double step = p1 / slope;
      x -= step;
      if (std::abs(step) < 1e-16) break;
    }
    rule.point.push_back(x);
    rule.weight.push_back(2.0 / ((1.0 - x * x) * slope * slope));
  }
  return rule;
}

}  // namespace

const GaussRule& gauss_rule(int n) {
  require(n >= 1 && n <= 16, "a Gauss rule of {} points; 1 to 16 are possible", n);
  static const std::vector<GaussRule> rules = [] {
    std::vector<GaussRule> all(1);
    for (int i = 1; i <= 16; ++i) all.push_back(make_rule(i));
    return all;
  }();
  return rules[n];
}

}  // namespace sunder::shell
