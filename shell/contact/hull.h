#pragma once
// Faces of convex bodies.
#include <vector>

#include "coupler/core/vec.h"

namespace sunder::shell {

struct Plane {
  Vec3 normal;    // outward
  double offset;  // inside: normal . x <= offset [m]
};

/// Planes of the convex hull of `corners` [m]: those through three corners with all others on one side. The tolerance
/// is 1e-7 of the extent. Many corners in one plane bound no body, and have none.
std::vector<Plane> hull_planes(const std::vector<Vec3>& corners);

}  // namespace sunder::shell
