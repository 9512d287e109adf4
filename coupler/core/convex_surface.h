#pragma once
// Convex hulls of points, and the volume of a closed surface.
#include <vector>

#include "coupler/core/body.h"

namespace sunder {

/// Signed volume [m^3]: positive where triangles are counter-clockwise seen from outside.
double enclosed_volume(const Surface& surface);

/// Convex hull of points (CGAL), with corners sorted by coordinates. Flat points give no triangles.
Surface convex_surface(const std::vector<Vec3>& points);

}  // namespace sunder
