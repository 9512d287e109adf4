#pragma once
// Solids from the OFF, OBJ, PLY, STL and glTF files beside a scene.
#include <array>
#include <string>
#include <vector>

#include "coupler/core/body.h"
#include "coupler/core/convex_surface.h"
#include "coupler/scene/load.h"

namespace sunder::scene {

/// A solid with its surface and its division into convex parts, in the file's axes [m].
struct Solid {
  Surface surface;                       // of a hull or of faces
  std::vector<std::vector<Vec3>> parts;  // corners of convex parts; their volumes differ from it by kMostAdded at most
  bool is_hull = true;                   // the one part has all corners of the surface
  double volume = 0.0;                   // enclosed by the surface [m^3]
};
constexpr int kMostHullCorners = 128;  // of a convex part: the cost of collision grows at least with their square
constexpr int kMostTriangles = 20000;  // of a surface of kind EXACT
constexpr int kMostParts = 128;        // of a solid: each is a shape by itself in the engine
constexpr double kMostAdded = 1e-2;    // share of the volume that merging down to kMostParts may add
constexpr double kMostLost =
    5e-2;  // share of its volume that a part may lose where it is simplified to kMostHullCorners
constexpr double kLeastVolume = 1e-9;  // share of the cube of the diagonal below which a solid counts as flat

/// Reads the solid in the mesh's file. Throws Error (bad_scene) at the place of `field`.
Solid read_mesh(const LoadedScene& scene, const std::string& field, const proto::Mesh& mesh);

/// The corners of a solid's surface over time, first those of its mesh.
struct SolidShapes {
  Surface surface;                         // at time 0
  std::vector<double> times;               // [s], from 0
  std::vector<std::vector<Vec3>> corners;  // at these times [m]
};
/// Reads the shapes of a body with a deformation; `field` is the body. Throws Error (bad_scene) at the place where a
/// mesh has other faces than the first, or a surface crosses itself.
SolidShapes read_shapes(const LoadedScene& scene, const std::string& field, const proto::Body& body);

/// A face of a file.
struct Polygon {
  std::vector<int> corners;  // indices of the file's points, from 0
  int line = 0;              // of the file, or its number among the faces, from 1
  int tag = -1;              // index of a FaceTag; -1: none
  std::vector<int>
      texture{};  // of each corner: index of its texture coordinates, from 0; -1: none; empty: no corner has
};
/// What an OBJ or glTF file says of faces.
struct FaceTag {
  std::vector<std::string> groups;  // of g, and of o; of nodes and meshes
  std::string usemtl;               // empty: none
};
/// Triangles of a polygon that may be concave, by ear clipping in the plane of its mean normal. Throws Error (bad_mesh)
/// where it has too few or too many corners, names a point that is not there, or crosses itself. `word` says what
/// Polygon::line counts.
std::vector<std::array<int, 3>> triangulated(const std::vector<Vec3>& points, const Polygon& polygon,
                                             const std::string& word);

constexpr int kMostSurfaceTriangles = 300000;  // of a mesh that becomes shells

/// The faces of a file as triangles, nothing merged or turned.
struct FileSurface {
  std::vector<Vec3> points;                   // [m]
  std::vector<std::array<int, 3>> triangles;  // indices of points
  std::vector<int> lines;                     // of the face of each triangle
  std::vector<int> tag_of;                    // of the face of each triangle: index of `tags`; -1: none
  std::vector<FaceTag> tags;
  std::vector<Vec3> colours;  // of points: red, green, blue, 1 is full; empty: none. A point without has no numbers
  std::string word;           // what lines count
  int faces = 0;
  // Texture coordinates of corner k of triangle t, at 3 t + k; NaN: none. Empty: the file has none.
  std::vector<Vec2> texture{};
};
/// Reads the faces of a file; `unit` is its unit of length [m], `field` the mesh. Throws Error (bad_scene).
FileSurface read_surface(const LoadedScene& scene, const std::string& field, const std::string& path, double unit);

/// Triangles of a closed surface that does not cross itself. They are counter-clockwise seen from outside, whatever the
/// file's order. A component inside another one is a hollow. Throws Error (bad_mesh) with place, line and remedy.
/// `word` says what Polygon::line counts.
Surface closed_surface(const std::vector<Vec3>& points, const std::vector<Polygon>& polygons,
                       const std::string& word = "line");

/// Winding number of the surface about a point that is not on it: 1 inside, 0 outside, to round-off (Van Oosterom and
/// Strackee 1983).
double winding_number(const Surface& surface, const Vec3& point);

/// Corners and volume [m^3] of a convex hull.
struct Hull {
  std::vector<Vec3> corners;
  double volume = 0.0;
};
/// Convex hull of points, without points that round-off leaves on its edges and faces. Flat points give an empty hull.
Hull hull_of(const std::vector<Vec3>& points);

/// At most so many of the corners of a hull, those that stand out most. Their hull lies inside it. Throws Error
/// (bad_mesh) where it has lost more than kMostLost of the volume. The ball is the worst body: it loses 4.7 % with
/// kMostHullCorners.
Hull simplified_hull(const Surface& hull, int most_corners = kMostHullCorners);

/// Convex parts of the solid inside a closed surface, each by its corners [m]. A binary partition of space cuts it
/// along the planes of its faces. Then pairs of parts whose hull is their union are merged, and slivers are left out.
/// Throws Error (bad_mesh) where more than kMostParts remain.
std::vector<std::vector<Vec3>> convex_parts(const Surface& surface);

}  // namespace sunder::scene
