#include "shell/geometry/parameter_place.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace sunder::shell {

double edge_tolerance(const Patch& patch) {
  return kOnEdge * std::max(patch.knots_u.end() - patch.knots_u.begin(), patch.knots_v.end() - patch.knots_v.begin());
}

Vec2 moved_onto_edges(const Patch& patch, const Vec2& p) {
  const double of_patch = edge_tolerance(patch);
  const auto moved = [&](double at, const KnotVector& knots) {
    const double tolerance = std::max(of_patch, kOfElement * (knots.end() - knots.begin()) / knots.spans());
    if (std::abs(at - knots.begin()) <= tolerance) return knots.begin();
    if (std::abs(at - knots.end()) <= tolerance) return knots.end();
    return at;
  };
  return {moved(p.x(), patch.knots_u), moved(p.y(), patch.knots_v)};
}

std::string parameter_range(const Patch& patch) {
  return fmt::format("from {:.9g} to {:.9g} along u and from {:.9g} to {:.9g} along v", patch.knots_u.begin(),
                     patch.knots_u.end(), patch.knots_v.begin(), patch.knots_v.end());
}

}  // namespace sunder::shell
