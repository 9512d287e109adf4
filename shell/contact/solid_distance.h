#pragma once
// Signed distance to the surface of a solid, convex or not.
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "coupler/core/body.h"

namespace sunder::shell {

/// Signed distance in body coordinates, exact to round-off. A tree of boxes finds the nearest point. The normal there
/// gives the sign; at edges and corners it is angle-weighted (Baerentzen and Aanaes 2005).
class SolidDistance {
 public:
  explicit SolidDistance(const Surface& surface);
  struct Found {
    double value;           // [m], negative inside
    Vec3 normal;            // gradient of the distance, unit
    Vec3 point;             // of the surface, nearest to x
    std::int32_t triangle;  // that holds it, by its place in the tree
  };
  /// `guess`: the triangle of a point nearby, which makes the search short; -1: none is known.
  Found at(const Vec3& x, std::int32_t guess = -1) const;
  /// Moves the corners. Triangles stay as they were; the tree keeps its shape.
  void move(const std::vector<Vec3>& corners);
  /// `velocities` of the corners [m/s], for velocity_at(); empty: at rest.
  void set_velocities(std::vector<Vec3> velocities) { velocities_ = std::move(velocities); }
  /// Velocity of the surface at its point nearest to x, and at a point of it [m/s].
  Vec3 velocity_at(const Vec3& x) const;
  Vec3 velocity_at(const Vec3& point, std::int32_t triangle) const;
  bool moves() const { return !velocities_.empty(); }
  std::size_t triangles() const { return triangles_.size(); }
  /// No point of the surface has moved further than this changed meanwhile [m].
  double moved() const { return moved_; }
  /// Sides of the box around the surface, along the body's axes [m].
  const Vec3& extent() const { return extent_; }

 private:
  struct Triangle {
    Vec3 a, ab, ac;
    Vec3 normal;
    std::int32_t number = 0;  // in the surface
  };
  struct Node {
    Vec3 low, high;
    std::int32_t first, count;  // of triangles. count 0: the children are the nodes index + 1 and `first`
  };
  struct Nearest {
    double squared;
    Vec3 point;
    std::int32_t triangle;
    int feature;  // 0 the face, 1 to 3 a corner, 4 to 6 an edge
  };
  Triangle made(const std::vector<Vec3>& corners, std::int32_t number) const;
  /// Normal of the edge that begins at corner k of a triangle, and of that corner, weighted by angles.
  Vec3 edge_normal(std::int32_t number, int k) const;
  Vec3 corner_normal(std::int32_t number, int k) const;
  void build(std::vector<Triangle>& triangles, std::size_t begin, std::size_t end);
  Nearest nearest(const Vec3& x, std::int32_t guess) const;
  void look(const Triangle& t, std::int32_t index, const Vec3& x, Nearest& best) const;

  std::vector<Triangle> triangles_;  // in the order of the tree's leaves
  std::vector<Node> nodes_;
  Vec3 extent_ = Vec3::Zero();
  // Of the surface: corners, those of each triangle, the triangles beside its edges, and those around each corner.
  std::vector<Vec3> corners_;
  std::vector<std::array<int, 3>> corners_of_, beside_;
  std::vector<std::vector<int>> around_;
  std::vector<std::int32_t> place_;  // of each triangle in triangles_
  std::vector<Vec3> velocities_;
  double moved_ = 0.0;
};

}  // namespace sunder::shell
