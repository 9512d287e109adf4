#pragma once
// Flattens a part of a surface of triangles, with as little stretch as can be.
#include <optional>
#include <vector>

#include "shell/meshes/triangle_mesh.h"

namespace sunder::shell {

/// A part of a mesh in the plane.
struct Flat {
  std::vector<int> triangles;  // of the mesh
  std::vector<int> points;     // of the mesh, by local number
  std::vector<int> local;      // [point of the mesh]: local number; -1: not in the part
  std::vector<Vec2> at;        // of each local point; the plane has the area of the surface [m]
  std::vector<double> most;    // stretch of each triangle: the larger of its longest stretch and shrinkage, at least 1;
                               // 1e9 where it is turned over
};

/// Flattens triangles that hang together and have at least one border: least squares conformal maps (Levy et al. 2002),
/// then as rigid as possible (Liu et al. 2008). Returns nothing where the equations have no solution.
std::optional<Flat> flatten(const TriangleMesh& mesh, const std::vector<int>& triangles);

/// Number of handles of a part, twice: 0 for a sphere, a disc, and a disc with holes; borders are counted in `loops`.
struct PartShape {
  int handles = 0;  // 2 - loops - V + E - F
  int loops = 0;
};
PartShape shape_of(const TriangleMesh& mesh, const std::vector<int>& triangles);

}  // namespace sunder::shell
