// Reads the faces of a mesh file as triangles of a surface, closed or not.
#include <algorithm>
#include <cmath>

#include "coupler/scene/mesh_reader.h"

namespace sunder::scene {

FileSurface read_surface(const LoadedScene& scene, const std::string& field, const std::string& path, double unit) {
  proto::Mesh message;
  message.set_path(path), message.set_scale(unit), message.set_surface(proto::Mesh::EXACT);
  const MeshFile file = read_mesh_file(scene, field, message);
  if (file.polygons.empty()) file.fail("has points and no faces, so there is no surface; export faces as well");
  FileSurface out{file.points, {}, {}, {}, file.tags, file.colours, file.place, static_cast<int>(file.polygons.size())};
  if (!out.colours.empty()) out.colours.resize(out.points.size(), Vec3::Constant(std::nan("")));
  try {
    for (const Polygon& polygon : file.polygons) {
      for (const auto& t : triangulated(file.points, polygon, file.place))
        out.triangles.push_back(t), out.lines.push_back(polygon.line), out.tag_of.push_back(polygon.tag);
      if (static_cast<int>(out.triangles.size()) > kMostSurfaceTriangles)
        file.fail(fmt::format("has more than {} triangles; {}: shells lose what is finer than element_m",
                              kMostSurfaceTriangles, kReduce));
    }
  } catch (const Error& e) {
    if (!e.file.empty()) throw;
    file.fail(e.what());
  }
  return out;
}

}  // namespace sunder::scene
