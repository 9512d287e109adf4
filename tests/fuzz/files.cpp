// Files that a user gives: scenes with settings, PGM images, meshes.
#include <algorithm>
#include <cmath>
#include <limits>

#include "coupler/scene/load.h"
#include "coupler/scene/mesh.h"
#include "shell/io/pgm_file.h"
#include "shell/meshes/triangle_mesh.h"
#include "tests/fuzz/targets.h"

namespace sunder::fuzz {

/// "!name.path=value", newline, scene: with a setting. Anything else: a scene.
void run_scene(const std::uint8_t* data, std::size_t size) {
  std::vector<std::string> settings;
  if (size > 0 && data[0] == '!') {
    const auto* end = std::find(data, data + size, '\n');
    settings.emplace_back(data + 1, end);
    size -= static_cast<std::size_t>(end - data), data = end;
  }
  const std::string path = file_with("scene.textproto", data, size);
  refuses_by_name([&] {
    const auto scene = scene::load(path, settings);
    demand(scene.hash.size() == 64, "a scene without a hash");
  });
}

void run_pgm(const std::uint8_t* data, std::size_t size) {
  const std::string path = file_with("map.pgm", data, size);
  refuses_by_name([&] {
    const auto image = shell::read_pgm(path, [](double width, double height) {  // as strength maps do
      require(std::min(width, height) >= 2.0 && std::max(width, height) <= 16384.0, "size");
    });
    demand(image.pixels.size() == static_cast<std::size_t>(image.width) * image.height, "pixels are missing");
    for (const double x : {0.0, 0.3, 1.0})
      for (const double y : {0.0, 0.7, 1.0}) {
        const double grey = image.grey(x, y);
        demand(grey >= 0.0 && grey <= 1.0, "a grey beyond black and white");
      }
  });
}

/// First byte: the format, the scale, and whether the surface is meant as it is.
void run_mesh(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return;
  constexpr double kMost = std::numeric_limits<double>::max();
  constexpr double kScales[] = {1.0, 1e-3, 1e3, kMost, std::numeric_limits<double>::denorm_min(), 0.0, -1.0};
  constexpr const char* kNames[] = {"mesh.obj", "mesh.off", "mesh.ply", "mesh.stl"};
  constexpr const char* kGltf[] = {"mesh.glb", "mesh.gltf"};
  const std::string name = data[0] / 32 % 2 ? kGltf[data[0] & 1] : kNames[(data[0] & 1) + 2 * (data[0] >> 7)];
  scene::LoadedScene scene;
  scene.path = file_with(name, data + 1, size - 1);
  proto::Mesh mesh;
  mesh.set_path(name);
  const std::size_t scale = data[0] / 2 % 8;
  if (scale < std::size(kScales)) mesh.set_scale(kScales[scale]);
  if (data[0] / 16 % 2) mesh.set_surface(proto::Mesh::EXACT);
  refuses_by_name([&] {
    const auto solid = scene::read_mesh(scene, "bodies[0].mesh", mesh);
    const auto& [corners, triangles] = solid.surface;
    demand(corners.size() >= 4 && triangles.size() >= 4 && solid.volume > 0.0, "a solid without a volume");
    for (const Vec3& c : corners) demand(c.allFinite(), "a corner that is not finite");
    for (const auto& t : triangles)
      for (const int k : t) demand(k >= 0 && k < static_cast<int>(corners.size()), "a triangle of no corner");
    demand(!solid.parts.empty(), "a solid without parts");
    for (const auto& part : solid.parts) demand(part.size() >= 4, "a part without a volume");
  });
}

/// First byte: the format and the distance of points that become one.
void run_surface(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return;
  constexpr const char* kNames[] = {"surface.obj", "surface.off", "surface.ply",
                                    "surface.stl", "surface.glb", "surface.gltf"};
  constexpr double kWelds[] = {0.0, 1e-3, 1.0};
  const std::string name = kNames[data[0] % std::size(kNames)];
  const double weld = kWelds[data[0] / std::size(kNames) % std::size(kWelds)];
  scene::LoadedScene scene;
  scene.path = file_with(name, data + 1, size - 1);
  refuses_by_name([&] {
    const scene::FileSurface file = scene::read_surface(scene, "shells[0].mesh", name, 1.0);
    std::vector<shell::FileTriangle> triangles;
    const auto points = static_cast<int>(file.points.size());
    for (const Vec3& x : file.points) demand(x.allFinite(), "a point that is not finite");
    for (std::size_t t = 0; t < file.triangles.size(); ++t) {
      for (const int k : file.triangles[t]) demand(k >= 0 && k < points, "a triangle of no point");
      demand(file.tag_of[t] < static_cast<int>(file.tags.size()), "a triangle of no group");
      triangles.push_back({file.triangles[t], file.lines[t], file.tag_of[t]});
    }
    demand(file.texture.empty() || file.texture.size() == 3 * triangles.size(), "corners without texture coordinates");
    const shell::TriangleMesh m = shell::make_triangle_mesh(file.points, triangles, weld, file.word);
    for (int t = 0; t < static_cast<int>(m.triangles.size()); ++t) {
      demand(m.area(t) > 0.0, "a triangle without an area");
      for (int e = 0; e < 3; ++e) {
        const int other = m.beside[t][e];
        if (other < 0) continue;
        const auto& near = m.beside[other];
        demand(std::count(near.begin(), near.end(), t) > 0, "a neighbour that has another neighbour");
      }
    }
  });
}

/// A PC2 file, for a body whose mesh has the corners of a box.
void run_pc2(const std::uint8_t* data, std::size_t size) {
  static const std::string box =
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
      "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
  file_with("box.obj", reinterpret_cast<const std::uint8_t*>(box.data()), box.size());
  scene::LoadedScene scene;
  scene.path = file_with("points.pc2", data, size);
  proto::Body body;
  body.mutable_mesh()->set_path("box.obj"), body.mutable_mesh()->set_surface(proto::Mesh::EXACT);
  proto::PointCache& cache = *body.mutable_deformation()->mutable_cache();
  cache.set_path("points.pc2"), cache.set_frames_per_second(24.0);
  refuses_by_name([&] {
    const auto shapes = scene::read_shapes(scene, "bodies[0]", body);
    demand(!shapes.times.empty() && shapes.times.size() == shapes.corners.size(), "shapes without times");
    for (std::size_t k = 0; k < shapes.times.size(); ++k) {
      demand(shapes.times[k] >= 0.0 && (k == 0 || shapes.times[k] > shapes.times[k - 1]), "times that do not rise");
      demand(shapes.corners[k].size() == shapes.surface.corners.size(), "corners are missing");
      for (const Vec3& c : shapes.corners[k]) demand(c.allFinite(), "a corner that is not finite");
    }
  });
}

}  // namespace sunder::fuzz
