#pragma once
// The parameter domain cut by the cracks: a constrained Delaunay triangulation. Connected triangles are the pieces; the
// same triangles are drawn and become collision shapes.
#include <array>
#include <span>
#include <vector>

#include "shell/fracture/crack_graph.h"
#include "shell/geometry/knots.h"

namespace sunder::shell {

struct Triangulation {
  std::vector<Vec2> vertices;
  std::vector<std::array<int, 3>> triangles;   // counter-clockwise
  std::vector<std::array<int, 3>> neighbours;  // across the edge opposite a corner; -1: crack or border
  std::vector<std::array<char, 3>> crack;      // that edge is a crack (border: 0, unless a crack runs on it)
  std::vector<int> piece;                      // of each triangle, numbered from 0
  int pieces = 0;
  std::vector<int> owner;               // piece of each query point
  std::vector<int> by_piece, first_of;  // triangles by pieces; where each piece begins, and the end

  /// Triangles of a piece, in rising order.
  std::span<const int> triangles_of(int number) const {
    return std::span(by_piece).subspan(first_of[number], first_of[number + 1] - first_of[number]);
  }
};

/// Vertices: crack vertices, and knots of the patch that lie in one of the boxes and not too near a crack. Pieces that
/// are only counted and measured need no knots. `queries` are points inside the domain whose pieces are found. Pieces
/// smaller than `sliver` [m^2] are joined to their largest neighbour.
Triangulation triangulate(const KnotVector& u, const KnotVector& v, const CrackGraph& cracks,
                          const std::vector<Vec2>& queries, double spacing, double sliver,
                          std::span<const Eigen::AlignedBox2d> knots_in);

double triangle_area(const Vec2& a, const Vec2& b, const Vec2& c);

}  // namespace sunder::shell
