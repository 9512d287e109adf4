// Makes a solid from a mesh file.
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include <Eigen/Dense>
#include <Eigen/Geometry>

#include "coupler/scene/mesh_reader.h"

namespace sunder::scene {
namespace {

template <class... Args>
void check(bool good, fmt::format_string<Args...> format, Args&&... args) {
  if (!good) throw Error(Exit::kBadInput, "bad_mesh", fmt::format(format, std::forward<Args>(args)...));
}

Solid hull_solid(const std::vector<Vec3>& points) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : points) box.extend(p);
  Solid solid;
  solid.surface = convex_surface(points);
  const Surface& hull = solid.surface;
  solid.volume = hull.corners.empty() ? 0.0 : enclosed_volume(hull);
  check(solid.volume > kLeastVolume * std::pow(box.diagonal().norm(), 3), "has a flat hull; a body needs a volume");
  if (static_cast<int>(hull.corners.size()) <= kMostHullCorners) {
    solid.parts = {hull.corners};
    return solid;
  }
  check(static_cast<int>(hull.triangles.size()) <= kMostTriangles,
        "has a hull of {} triangles, at most {} can be used; thin its points out", hull.triangles.size(),
        kMostTriangles);
  solid.is_hull = false;
  solid.parts = {simplified_hull(hull).corners};
  return solid;
}

}  // namespace

std::string mesh_suffix(const std::filesystem::path& file) {
  std::string out = file.extension();
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

MeshFile read_mesh_file(const LoadedScene& scene, const std::string& field, const proto::Mesh& mesh,
                        bool with_texture) {
  struct Format {
    const char* suffix;
    void (*read)(MeshFile&);
  };
  constexpr std::array<Format, 6> formats{{{".off", read_off},
                                           {".obj", read_obj},
                                           {".ply", read_ply},
                                           {".stl", read_stl},
                                           {".glb", read_gltf},
                                           {".gltf", read_gltf}}};
  MeshFile out{scene,
               field + ".path",
               mesh.path(),
               scene.file_beside(field + ".path", mesh.path()),
               mesh.has_scale() ? mesh.scale() : 1.0,
               mesh.surface() == proto::Mesh::EXACT,
               {},
               {}};
  out.with_texture = with_texture;
  const std::string suffix = mesh_suffix(mesh.path());
  const auto* format =
      std::find_if(formats.begin(), formats.end(), [&](const Format& f) { return suffix == f.suffix; });
  if (format == formats.end())
    out.fail(fmt::format(
        "ends in '{}'; files that end in .off, .obj, .ply, .stl, .glb or .gltf are read: export one of them", suffix));
  format->read(out);
  return out;
}

void MeshFile::fail(const std::string& what) const { scene.fail(field, fmt::format("'{}' {}", path, what)); }

void MeshFile::fail_at(const std::string& where, const std::string& what) const {
  scene.fail(field, fmt::format("'{}': {}: {}", path, where, what));
}

void MeshFile::add(const Vec3& point, const std::string& where) {
  if (!point.allFinite())
    fail_at(where, fmt::format("({}, {}, {}) is no point of three numbers", point.x(), point.y(), point.z()));
  if (points.size() >= kMostPoints) fail(fmt::format("has more than {} points; {}", kMostPoints, kReduce));
  points.push_back(scale * point);
  if (!(points.back().cwiseAbs().maxCoeff() <= kFarthest))
    fail_at(where, fmt::format("({}, {}, {}) is further than {:g} m away, scaled by {}; is scale right?", point.x(),
                               point.y(), point.z(), kFarthest, scale));
}

void MeshFile::colour(const Vec3& rgb) {
  colours.resize(points.size(), Vec3::Constant(std::nan("")));
  colours.back() = rgb;
}

Solid read_mesh(const LoadedScene& scene, const std::string& field, const proto::Mesh& mesh) {
  scene.check(!mesh.has_scale() || (std::isfinite(mesh.scale()) && mesh.scale() > 0.0), field + ".scale",
              "is {}; must be positive", mesh.scale());
  const MeshFile file = read_mesh_file(scene, field, mesh);
  if (file.points.size() < 4) file.fail(fmt::format("has {} points; a body has at least 4", file.points.size()));
  Solid solid;
  try {
    if (mesh.surface() == proto::Mesh::HULL) return hull_solid(file.points);
    solid.is_hull = false;
    solid.surface = closed_surface(file.points, file.polygons, file.place);
    solid.parts = convex_parts(solid.surface);
  } catch (const Error& e) {
    scene.fail(field + ".path", fmt::format("'{}' {}", mesh.path(), e.what()));
  }
  solid.volume = enclosed_volume(solid.surface);
  return solid;
}

}  // namespace sunder::scene
