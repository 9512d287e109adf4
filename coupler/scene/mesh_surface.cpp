// Reads the faces of a mesh file as triangles of a surface, closed or not.
#include <algorithm>
#include <cmath>

#include "coupler/scene/mesh_reader.h"

namespace sunder::scene {

namespace {

// Texture coordinates of a polygon at one of the file's points.
Vec2 texture_at(const MeshFile& file, const Polygon& polygon, int point) {
  const auto corner = std::find(polygon.corners.begin(), polygon.corners.end(), point) - polygon.corners.begin();
  const int index = polygon.texture.empty() ? -1 : polygon.texture[corner];
  return index < 0 ? Vec2(Vec2::Constant(std::nan(""))) : file.texture[index];
}

}  // namespace

FileSurface read_surface(const LoadedScene& scene, const std::string& field, const std::string& path, double unit) {
  proto::Mesh message;
  message.set_path(path), message.set_scale(unit), message.set_surface(proto::Mesh::EXACT);
  const MeshFile file = read_mesh_file(scene, field, message, true);
  if (file.polygons.empty()) file.fail("has points and no faces, so there is no surface; export faces as well");
  FileSurface out{file.points, {}, {}, {}, file.tags, file.colours, file.place, static_cast<int>(file.polygons.size())};
  if (!out.colours.empty()) out.colours.resize(out.points.size(), Vec3::Constant(std::nan("")));
  try {
    for (const Polygon& polygon : file.polygons) {
      for (const auto& t : triangulated(file.points, polygon, file.place)) {
        out.triangles.push_back(t), out.lines.push_back(polygon.line), out.tag_of.push_back(polygon.tag);
        for (const int corner : t) out.texture.push_back(texture_at(file, polygon, corner));
      }
      if (static_cast<int>(out.triangles.size()) > kMostSurfaceTriangles)
        file.fail(fmt::format("has more than {} triangles; {}: shells lose what is finer than element_m",
                              kMostSurfaceTriangles, kReduce));
    }
  } catch (const Error& e) {
    if (!e.file.empty()) throw;
    file.fail(e.what());
  }
  if (file.texture.empty()) out.texture.clear();
  return out;
}

}  // namespace sunder::scene
