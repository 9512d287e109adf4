// Corner points of OFF and OBJ files.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "coupler/scene/load.h"

namespace sunder::scene {

std::vector<Vec3> read_mesh(const LoadedScene& scene, const std::string& field, const proto::ConvexMesh& mesh) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::weakly_canonical(fs::absolute(scene.path)).parent_path();
  const fs::path file = fs::weakly_canonical(folder / mesh.path());
  const auto [end, unused] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
  scene.check(end == folder.end(), field + ".path",
              "'{}' lies outside the scene's folder; put the mesh beside the scene", mesh.path());
  std::ifstream in(file);
  scene.check(in.good(), field + ".path", "'{}' cannot be read", mesh.path());
  const double scale = mesh.has_scale() ? mesh.scale() : 1.0;
  scene.check(std::isfinite(scale) && scale > 0.0, field + ".scale", "is {}; must be positive", scale);
  std::vector<Vec3> points;
  std::string line;
  const auto add = [&](std::istringstream& words) {
    Vec3 p;
    scene.check(static_cast<bool>(words >> p.x() >> p.y() >> p.z()) && p.allFinite(), field + ".path",
                "'{}': '{}' is no point of three numbers", mesh.path(), line);
    points.push_back(scale * p);
  };
  if (file.extension() == ".off") {
    std::getline(in, line);
    std::size_t count = 0;
    scene.check(line.rfind("OFF", 0) == 0 && static_cast<bool>(in >> count) && count < 1000000, field + ".path",
                "'{}' does not start as an OFF file does", mesh.path());
    std::getline(in, line);
    while (points.size() < count && std::getline(in, line)) {
      std::istringstream words(line);
      add(words);
    }
  } else {
    while (std::getline(in, line)) {
      std::istringstream words(line);
      std::string kind;
      if (words >> kind && kind == "v") add(words);
    }
  }
  scene.check(points.size() >= 4, field + ".path", "'{}' has {} points; a body has at least 4", mesh.path(),
              points.size());
  return points;
}

}  // namespace sunder::scene
