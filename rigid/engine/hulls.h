#pragma once
// Shapes as the narrow phase of this house (touch.h) wants them: convex parts with faces and edges.
#include <vector>

#include "coupler/core/body.h"

namespace sunder::rigid {

/// A convex part, in body or world coordinates [m]: its points and everything nearer to them than `radius`.
/// A sphere is one point with a radius; everything else is a polyhedron with radius 0.
struct Hull {
  struct Face {
    Vec3 normal = Vec3::UnitZ();  // outward
    double offset = 0.0;          // normal . point on the face
    std::vector<int> corners;     // anticlockwise from outside
  };
  struct Edge {
    int from = 0, to = 0;
    int direction = 0;  // indexes `directions`
  };
  double radius = 0.0;
  std::vector<Vec3> points;
  std::vector<Face> faces;
  std::vector<Edge> edges;
  std::vector<Vec3> directions;  // of the edges, parallel ones once

  bool is_point() const { return points.size() == 1; }
};

struct HullShape {
  bool is_half_space = false;  // below the body's xy plane
  std::vector<Hull> parts;     // body coordinates; none where it is a half space
  double reach = 0.0;          // of the farthest point from the centre of mass [m]
};

/// Of a body that check_body() lets through. Throws Error (bad_body) with id, name, value and remedy where a convex
/// part cannot be held.
HullShape make_hull_shape(const RigidBody& body);

/// `world` becomes `local` at that pose. The two have the same topology from the second call on, so nothing is
/// allocated.
void place(const Hull& local, const BodyMotion& pose, Hull& world);

}  // namespace sunder::rigid
