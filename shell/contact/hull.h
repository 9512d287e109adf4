#pragma once
// Faces of convex bodies.
#include <vector>

#include "coupler/core/vec.h"

namespace sunder::shell {

struct Plane {
  Vec3 normal;    // outward
  double offset;  // normal . x <= offset inside
};

/// Of the convex hull of some corners: through each triple that has all others on one side, to 1e-7 of their extent.
std::vector<Plane> hull_planes(const std::vector<Vec3>& corners);

}  // namespace sunder::shell
