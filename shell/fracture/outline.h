#pragma once
// The outline of a piece, triangulated without inner vertices: what is drawn of a shard, and the base of its convex
// parts.
#include <array>
#include <vector>

#include "shell/fracture/triangulation.h"

namespace sunder::shell {

struct Outline {
  std::vector<Vec2> vertices;
  std::vector<std::array<int, 3>> triangles;  // counter-clockwise
  std::vector<std::array<int, 2>> border;     // edges with the piece on their left
};

Outline outline_of(const Triangulation& t, int piece);

/// Convex polygons that cover the outline: its triangles, merged while the hull of each adds less than `tolerance`
/// [m^2].
std::vector<std::vector<Vec2>> convex_parts(const Outline& outline, double tolerance);

}  // namespace sunder::shell
