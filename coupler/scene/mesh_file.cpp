// Corner points of OFF and OBJ files.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

#include "coupler/scene/load.h"

namespace sunder::scene {
namespace {

constexpr double kFarthest = 1e6;  // of a point from the origin [m]; squares and volumes of such numbers are finite

Hull hull_of(const LoadedScene& scene, const std::string& field, const std::string& path,
             const std::vector<Vec3>& points) {
  using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
  std::vector<Point> in;
  Eigen::AlignedBox3d box;
  for (const Vec3& p : points) in.emplace_back(p.x(), p.y(), p.z()), box.extend(p);
  CGAL::Surface_mesh<Point> surface;
  CGAL::convex_hull_3(in.begin(), in.end(), surface);
  Hull hull;
  for (const auto v : surface.vertices())
    hull.corners.emplace_back(surface.point(v).x(), surface.point(v).y(), surface.point(v).z());
  double volume = 0.0;
  for (const auto f : surface.faces()) {
    std::array<int, 3> corners{};
    int n = 0;
    for (const auto v : surface.vertices_around_face(surface.halfedge(f)))
      if (n < 3) corners[n++] = static_cast<int>(v.idx());
    hull.triangles.push_back(corners);
    const Vec3 origin = hull.corners[0];
    volume += (hull.corners[corners[0]] - origin)
                  .dot((hull.corners[corners[1]] - origin).cross(hull.corners[corners[2]] - origin)) /
              6.0;
  }
  scene.check(volume > 1e-9 * std::pow(box.diagonal().norm(), 3), field + ".path",
              "'{}': the hull of its points is flat; a body needs a volume", path);
  scene.check(static_cast<int>(hull.corners.size()) <= kMostHullCorners, field + ".path",
              "'{}': its hull has {} corners, at most {} can be used; simplify it", path, hull.corners.size(),
              kMostHullCorners);
  return hull;
}

}  // namespace

Hull read_mesh(const LoadedScene& scene, const std::string& field, const proto::ConvexMesh& mesh) {
  const std::filesystem::path file = scene.file_beside(field + ".path", mesh.path());
  std::ifstream in(file);
  const double scale = mesh.has_scale() ? mesh.scale() : 1.0;
  scene.check(std::isfinite(scale) && scale > 0.0, field + ".scale", "is {}; must be positive", scale);
  std::vector<Vec3> points;
  std::string line;
  const auto add = [&](std::istringstream& words) {
    Vec3 p;
    scene.check(static_cast<bool>(words >> p.x() >> p.y() >> p.z()) && p.allFinite(), field + ".path",
                "'{}': '{}' is no point of three numbers", mesh.path(), line);
    points.push_back(scale * p);
    scene.check(points.back().cwiseAbs().maxCoeff() <= kFarthest, field + ".path",
                "'{}': '{}' is further than {:g} m away, scaled by {}; is scale right?", mesh.path(), line, kFarthest,
                scale);
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
  return hull_of(scene, field, mesh.path(), points);
}

}  // namespace sunder::scene
