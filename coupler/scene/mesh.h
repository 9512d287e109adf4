#pragma once
// Solids that the OFF and OBJ files beside a scene hold.
#include <array>
#include <string>
#include <vector>

#include "coupler/core/body.h"
#include "coupler/scene/load.h"

namespace sunder::scene {

struct Solid {
  Surface surface;                       // in the file's axes [m]; of a hull its corners only
  std::vector<std::vector<Vec3>> parts;  // convex, together the solid to kMostAdded of its volume; a hull is one
  bool is_hull = true;
  double volume = 0.0;  // enclosed by the surface [m^3]
};
constexpr int kMostHullCorners = 128;  // collision tests grow with the square and more
constexpr int kMostTriangles = 20000;  // of a surface that is taken as it is
constexpr int kMostParts = 128;        // each is a shape by itself to the engine
constexpr double kMostAdded = 1e-2;    // of the volume, by hulls of parts that are merged to come down to kMostParts
constexpr double kLeastVolume = 1e-9;  // of the cube of the diagonal: what is less is flat

/// What the file below the scene's folder holds. Throws Error (bad_scene) at the place of `field`.
Solid read_mesh(const LoadedScene& scene, const std::string& field, const proto::Mesh& mesh);

struct Polygon {
  std::vector<int> corners;  // of the file's points, from 0
  int line = 0;              // of the file
};
/// Triangles of a closed surface that does not cross itself, turned so that they are counter-clockwise from outside
/// whichever way the file has them; a part that lies within another one is a hollow. Throws Error (bad_mesh) with the
/// place, the line and what to mend.
Surface closed_surface(const std::vector<Vec3>& points, const std::vector<Polygon>& polygons);

/// Signed [m^3]: positive where triangles are counter-clockwise from outside.
double enclosed_volume(const Surface& surface);
/// How often the surface goes round the point: 1 inside, 0 outside, to round-off off the surface itself.
double winding_number(const Surface& surface, const Vec3& point);

/// The convex hull of points, its corners in the order of their coordinates; no triangles where the points are flat.
Surface convex_surface(const std::vector<Vec3>& points);

/// The convex hull's corners, and its volume [m^3]; empty where the points are flat.
struct Hull {
  std::vector<Vec3> corners;
  double volume = 0.0;
};
Hull hull_of(const std::vector<Vec3>& points);

/// Convex parts of what a closed surface encloses. It is cut along the planes of its own faces, those first that leave
/// nothing outside, and parts whose hull is their union are merged again. Throws Error (bad_mesh) where these are too
/// many.
std::vector<std::vector<Vec3>> convex_parts(const Surface& surface);

}  // namespace sunder::scene
