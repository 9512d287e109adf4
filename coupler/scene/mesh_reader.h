#pragma once
// Points and faces of a mesh file, before anything is made of them.
#include <filesystem>
#include <string>
#include <vector>

#include "coupler/scene/mesh.h"

namespace sunder::scene {

constexpr std::size_t kMostPoints = 1000000;  // of a file
constexpr const char* kReduce =               // what to do with a mesh of too many faces
    "reduce it, for example by the modifier Decimate of Blender or by Quadric Edge Collapse Decimation of MeshLab";
constexpr double kFarthest = 1e6;  // coordinate of a point [m]: squares and volumes of such numbers are finite

/// A mesh file while it is read. A reader adds points and polygons, and names the place of what it refuses.
struct MeshFile {
  const LoadedScene& scene;
  std::string field, path;     // field of the messages; path as the scene gives it
  std::filesystem::path file;  // where it is
  double scale = 1.0;
  bool with_faces = false;
  std::vector<Vec3> points;  // scaled [m]
  std::vector<Polygon> polygons;
  std::string place = "line";  // of polygons: what their numbers count
  std::vector<FaceTag> tags{};
  std::vector<Vec3> colours{};  // as in FileSurface; of the points up to the last one that has a colour
  std::vector<Vec2> texture{};  // coordinates, as the file numbers them
  bool with_texture = false;

  /// Gives the last point a colour.
  void colour(const Vec3& rgb);

  /// Adds a point in the file's lengths. `where` says its place, as "line 5". Throws Error where it is not finite, or
  /// far away, or one too many.
  void add(const Vec3& point, const std::string& where);
  /// Throws Error (bad_scene) with the file's name.
  [[noreturn]] void fail(const std::string& what) const;
  /// The same at a place, as "line 5".
  [[noreturn]] void fail_at(const std::string& where, const std::string& what) const;
};

/// End of a file's name from its last point, in lower case: ".glb" of "A.GLB".
std::string mesh_suffix(const std::filesystem::path& file);
/// Reads a file by the end of its name. `field` is that of the mesh. Texture coordinates are read only on request:
/// solids do not need them, so what is wrong with them stops no solid.
MeshFile read_mesh_file(const LoadedScene& scene, const std::string& field, const proto::Mesh& mesh,
                        bool with_texture = false);
void read_off(MeshFile& mesh);
void read_obj(MeshFile& mesh);
/// ASCII and binary, little and big endian. Properties other than x, y, z and the faces' corners are skipped.
void read_ply(MeshFile& mesh);
/// ASCII and binary. Corners with equal coordinates are one point.
void read_stl(MeshFile& mesh);
/// glTF 2.0, text and binary, turned so that z is up. Nodes and meshes are groups.
void read_gltf(MeshFile& mesh);

}  // namespace sunder::scene
