#include "shell/geometry/parameter_place.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "shell/geometry/quadrature.h"

namespace sunder::shell {

double edge_tolerance(const Patch& patch) {
  return kOnEdge * std::max(patch.knots_u.end() - patch.knots_u.begin(), patch.knots_v.end() - patch.knots_v.begin());
}

double length_error(const Patch& patch, int direction) {
  constexpr int kGiven = 2, kExact = 8;  // points of the rules
  const KnotVector& knots = direction == 0 ? patch.knots_u : patch.knots_v;
  const KnotVector& across = direction == 0 ? patch.knots_v : patch.knots_u;
  const double middle = 0.5 * (across.begin() + across.end());
  const auto length = [&](int points) {
    const GaussRule& rule = gauss_rule(points);
    double sum = 0.0;
    for (int i = 0; i < knots.spans(); ++i)
      for (int a = 0; a < points; ++a) {
        const double at = knots.span_begin(i) + 0.5 * (1.0 + rule.point[a]) * knots.span_length(i);
        const SurfacePoint q = patch.evaluate(direction == 0 ? Vec2(at, middle) : Vec2(middle, at));
        sum += 0.5 * rule.weight[a] * knots.span_length(i) * (direction == 0 ? q.u : q.v).norm();
      }
    return sum;
  };
  return std::abs(length(kExact) - length(kGiven));
}

Vec2 moved_onto_edges(const Patch& patch, const Vec2& p) {
  const double of_patch = edge_tolerance(patch);
  const auto moved = [&](double at, int direction) {
    const KnotVector& knots = direction == 0 ? patch.knots_u : patch.knots_v;
    const double tolerance = of_patch + length_error(patch, direction);
    if (std::abs(at - knots.begin()) <= tolerance) return knots.begin();
    if (std::abs(at - knots.end()) <= tolerance) return knots.end();
    return at;
  };
  return {moved(p.x(), 0), moved(p.y(), 1)};
}

std::string parameter_range(const Patch& patch) {
  return fmt::format("from {:.9g} to {:.9g} along u and from {:.9g} to {:.9g} along v", patch.knots_u.begin(),
                     patch.knots_u.end(), patch.knots_v.begin(), patch.knots_v.end());
}

}  // namespace sunder::shell
