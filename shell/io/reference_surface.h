#pragma once
// From the face of a sheet that a scene gives to its middle surface.
#include <functional>

#include "shell/geometry/patch.h"
#include "shell/meshes/triangle_mesh.h"

namespace sunder::shell {

/// Distance by which a place of a patch moves along its normal x_u cross x_v [m].
using Distance = std::function<double(const Vec2&)>;

/// The surface at a distance along the normals, by interpolation at the Greville points with the same knots and
/// weights: exact for planes, cylinders, cones and spheres. Throws Error where it differs from the exact one by more
/// than `tolerance` [m], or where the surface is bent so much that its offset turns over.
Patch offset_patch(const Patch& patch, const Distance& distance, double tolerance);

/// Moves the points of a mesh so that each triangle moves by its distance along its normal, as well as the triangles
/// around a point allow: faces that meet in an edge or a corner stay faces that meet. `distance(point, part)` [m] is
/// that of a triangle of a part at a point. Throws Error with the place where a triangle turns over.
void offset_mesh(TriangleMesh& mesh, const std::function<double(int point, int part)>& distance);

}  // namespace sunder::shell
