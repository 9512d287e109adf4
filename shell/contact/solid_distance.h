#pragma once
// Signed distance to the surface of a solid that need not be convex.
#include <cstdint>
#include <vector>

#include "coupler/core/body.h"

namespace sunder::shell {

/// Exact to round-off: the nearest point by a tree of boxes, inside or outside by the normal there, which at edges and
/// corners is the angle-weighted one (Baerentzen and Aanaes 2005). Body coordinates.
class SolidDistance {
 public:
  explicit SolidDistance(const Surface& surface);
  struct Found {
    double value;  // [m], negative inside
    Vec3 normal;   // along which the distance grows, unit
  };
  Found at(const Vec3& x) const;
  /// Of the box around the surface, along the body's axes [m].
  const Vec3& extent() const { return extent_; }

 private:
  struct Triangle {
    Vec3 a, ab, ac;
    Vec3 normal;
    Vec3 corner_normal[3], edge_normal[3];  // of a, b, c; of ab, bc, ca
  };
  struct Node {
    Vec3 low, high;
    std::int32_t first, count;  // of triangles; 0: the children are this node's index + 1 and `first`
  };
  struct Nearest {
    double squared;
    Vec3 point;
    std::int32_t triangle;
    int feature;  // 0 the face, 1 to 3 a corner, 4 to 6 an edge
  };
  void build(std::vector<Triangle>& triangles, std::size_t begin, std::size_t end);
  void look(const Triangle& t, std::int32_t index, const Vec3& x, Nearest& best) const;

  std::vector<Triangle> triangles_;  // in the order of the tree's leaves
  std::vector<Node> nodes_;
  Vec3 extent_ = Vec3::Zero();
};

}  // namespace sunder::shell
