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

/// True where the piece is on both sides of a crack: one that ends within it, or around a sliver that was joined to it.
bool has_inner_cracks(const Triangulation& t, int piece);
/// The outline with these cracks: `border` holds both sides of each.
Outline outline_with_cracks(const Triangulation& t, int piece);

/// Convex polygons that cover the outline: its triangles, merged while the hull of each adds less than `tolerance`
/// [m^2].
std::vector<std::vector<Vec2>> convex_parts(const Outline& outline, double tolerance);

}  // namespace sunder::shell
