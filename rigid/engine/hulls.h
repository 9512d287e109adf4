#pragma once
// Shapes for the contact finder in touch.h: convex parts with faces and edges.
#include <vector>

#include "coupler/core/body.h"

namespace sunder::rigid {

/// A convex part, in body or world coordinates [m]: all points within `radius` of the hull of its points. A sphere is
/// one point with a radius. Every other part is a polyhedron with radius 0.
struct Hull {
  struct Face {
    Vec3 normal = Vec3::UnitZ();  // outward
    double offset = 0.0;          // normal . point, for a point of the face [m]
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
  std::vector<Vec3> directions;  // of the edges; parallel edges share one

  bool is_point() const { return points.size() == 1; }
};

/// The shape of a body.
struct HullShape {
  bool is_half_space = false;  // below the body's xy plane
  std::vector<Hull> parts;     // in body coordinates; a half space has none
  double reach = 0.0;          // distance of the farthest point from the centre of mass [m]
};

/// Shape of a body that check_body() accepts. Throws Error (bad_body) with id, name, value and remedy where a convex
/// part is flat, too detailed, or has corners that nearly coincide.
HullShape make_hull_shape(const RigidBody& body);

/// Moves `local`, in body coordinates, to a pose and stores it in `world`. A `world` from an earlier call for the same
/// part is reused without allocation.
void place(const Hull& local, const BodyMotion& pose, Hull& world);

}  // namespace sunder::rigid
