// Reads OFF and OBJ files.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <Eigen/Dense>
#include <Eigen/Geometry>

#include "coupler/scene/mesh.h"

namespace sunder::scene {
namespace {

constexpr double kFarthest = 1e6;  // coordinate of a point [m]: squares and volumes of such numbers are finite
constexpr std::size_t kMostPoints = 1000000;

struct File {
  std::vector<Vec3> points;  // scaled [m]
  std::vector<Polygon> polygons;
};

Solid hull_solid(const LoadedScene& scene, const std::string& field, const std::string& path,
                 const std::vector<Vec3>& points) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : points) box.extend(p);
  Solid solid;
  solid.surface = convex_surface(points);
  const Surface& hull = solid.surface;
  solid.volume = hull.corners.empty() ? 0.0 : enclosed_volume(hull);
  scene.check(solid.volume > kLeastVolume * std::pow(box.diagonal().norm(), 3), field + ".path",
              "'{}': the hull of its points is flat; a body needs a volume", path);
  scene.check(static_cast<int>(hull.corners.size()) <= kMostHullCorners, field + ".path",
              "'{}': its hull has {} corners, at most {} can be used; simplify it", path, hull.corners.size(),
              kMostHullCorners);
  solid.parts = {hull.corners};
  return solid;
}

class Reader {
 public:
  Reader(const LoadedScene& scene, const std::string& field, const proto::Mesh& mesh)
      : scene_(scene),
        field_(field + ".path"),
        path_(mesh.path()),
        file_(scene.file_beside(field + ".path", mesh.path())),
        in_(file_),
        scale_(mesh.has_scale() ? mesh.scale() : 1.0),
        exact_(mesh.surface() == proto::Mesh::EXACT) {}

  File read() {
    if (file_.extension() == ".off")
      off();
    else
      obj();
    scene_.check(out_.points.size() >= 4, field_, "'{}' has {} points; a body has at least 4", path_,
                 out_.points.size());
    return std::move(out_);
  }

 private:
  // Goes to the next line that is neither empty nor a comment; false at the end.
  bool next() {
    while (std::getline(in_, line_)) {
      ++number_;
      const std::size_t begin = line_.find_first_not_of(" \t\r");
      if (begin != std::string::npos && line_[begin] != '#') return true;
    }
    return false;
  }

  void point(std::istringstream& words) {
    Vec3 p;
    scene_.check(static_cast<bool>(words >> p.x() >> p.y() >> p.z()) && p.allFinite(), field_,
                 "'{}': line {}: '{}' is no point of three numbers", path_, number_, line_);
    out_.points.push_back(scale_ * p);
    scene_.check(out_.points.back().cwiseAbs().maxCoeff() <= kFarthest, field_,
                 "'{}': line {}: '{}' is further than {:g} m away, scaled by {}; is scale right?", path_, number_,
                 line_, kFarthest, scale_);
  }

  void off() {
    std::size_t points = 0, faces = 0;
    bool good = next() && line_.rfind("OFF", 0) == 0 && next();
    if (good) {
      std::istringstream words(line_);
      good =
          static_cast<bool>(words >> points) && points < kMostPoints && (!exact_ || static_cast<bool>(words >> faces));
    }
    scene_.check(good, field_, "'{}' does not start as an OFF file does", path_);
    while (out_.points.size() < points && next()) {
      std::istringstream words(line_);
      point(words);
    }
    if (!exact_) return;
    scene_.check(out_.points.size() == points, field_, "'{}' ends after {} of its {} points", path_, out_.points.size(),
                 points);
    while (out_.polygons.size() < faces) {
      scene_.check(next(), field_, "'{}' ends after {} of its {} faces", path_, out_.polygons.size(), faces);
      std::istringstream words(line_);
      std::size_t count = 0;
      words >> count;
      Polygon polygon{{}, number_};
      for (int corner; polygon.corners.size() < count && words >> corner;) polygon.corners.push_back(corner);
      scene_.check(count >= 3 && polygon.corners.size() == count, field_,
                   "'{}': line {}: '{}' is no face, which is the number of its corners and these", path_, number_,
                   line_);
      out_.polygons.push_back(std::move(polygon));
    }
  }

  void obj() {
    while (next()) {
      std::istringstream words(line_);
      std::string kind;
      words >> kind;
      if (kind == "v") point(words);
      if (kind != "f" || !exact_) continue;
      Polygon polygon{{}, number_};
      for (std::string word;
           words >> word;) {  // corner, or corner/texture/normal; negative: counted from the last point
        const long corner = std::strtol(word.c_str(), nullptr, 10), points = static_cast<long>(out_.points.size());
        scene_.check(corner != 0 && corner >= -points && corner <= points, field_,
                     "'{}': line {}: '{}' is none of the {} points before it, which count from 1", path_, number_, word,
                     points);
        polygon.corners.push_back(static_cast<int>(corner > 0 ? corner - 1 : points + corner));
      }
      out_.polygons.push_back(std::move(polygon));
    }
  }

  const LoadedScene& scene_;
  const std::string field_, path_;
  const std::filesystem::path file_;
  std::ifstream in_;
  const double scale_;
  const bool exact_;
  std::string line_;
  int number_ = 0;
  File out_;
};

}  // namespace

Solid read_mesh(const LoadedScene& scene, const std::string& field, const proto::Mesh& mesh) {
  scene.check(!mesh.has_scale() || (std::isfinite(mesh.scale()) && mesh.scale() > 0.0), field + ".scale",
              "is {}; must be positive", mesh.scale());
  const File file = Reader(scene, field, mesh).read();
  if (mesh.surface() == proto::Mesh::HULL) return hull_solid(scene, field, mesh.path(), file.points);
  Solid solid;
  solid.is_hull = false;
  try {
    solid.surface = closed_surface(file.points, file.polygons);
    solid.parts = convex_parts(solid.surface);
  } catch (const Error& e) {
    scene.fail(field + ".path", fmt::format("'{}' {}", mesh.path(), e.what()));
  }
  solid.volume = enclosed_volume(solid.surface);
  return solid;
}

}  // namespace sunder::scene
