#pragma once
// Normals of the smooth surface of which triangles are an approximation.
#include <vector>

#include "shell/meshes/flatten.h"

namespace sunder::shell {

/// Normals at the points of a part: of the polynomial of degree 2 over the plane that passes each point and is nearest
/// to those about it. Where there are too few, the mean of the triangles' normals by their angles.
std::vector<Vec3> smooth_normals(const TriangleMesh& mesh, const Flat& flat);

}  // namespace sunder::shell
