// Reads the shapes of a body that changes its shape.
#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Dense>

#include "coupler/core/smooth_keys.h"
#include "coupler/scene/mesh_reader.h"
#include "coupler/scene/point_cache.h"

namespace sunder::scene {
namespace {

// For each corner of the surface the number of a point of the file at that place.
std::vector<int> points_of(const Surface& surface, const std::vector<Vec3>& points) {
  std::map<std::array<double, 3>, int> known;
  for (std::size_t i = 0; i < points.size(); ++i)
    known.try_emplace({points[i].x() + 0.0, points[i].y() + 0.0, points[i].z() + 0.0}, static_cast<int>(i));
  std::vector<int> out;
  for (const Vec3& c : surface.corners) out.push_back(known.at({c.x() + 0.0, c.y() + 0.0, c.z() + 0.0}));
  return out;
}

// Throws Error where the surface of these corners is not closed or crosses itself.
void check_shape(const LoadedScene& scene, const std::string& field, const std::string& what,
                 const std::vector<Vec3>& corners, const Surface& surface, const std::string& remedy) {
  std::vector<Polygon> polygons;
  for (const auto& t : surface.triangles)
    polygons.push_back({{t[0], t[1], t[2]}, static_cast<int>(polygons.size()) + 1});
  try {
    closed_surface(corners, polygons, "triangle");
  } catch (const Error& e) {
    const std::string told = e.what();  // its remedy is for a file
    scene.fail(field, fmt::format("{}: {}; {}", what, told.substr(0, told.find(';')), remedy));
  }
}

// Mean normals of the corners, weighted by the angles of their faces.
std::vector<Vec3> normals_of(const Surface& s) {
  std::vector<Vec3> normals(s.corners.size(), Vec3::Zero());
  for (const auto& t : s.triangles)
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = s.corners[t[(k + 1) % 3]] - s.corners[t[k]], b = s.corners[t[(k + 2) % 3]] - s.corners[t[k]];
      const Vec3 across = a.cross(b);
      normals[t[k]] += std::atan2(across.norm(), a.dot(b)) * across.normalized();
    }
  for (Vec3& n : normals) n.normalize();
  return normals;
}

void add_inflated(const LoadedScene& scene, const std::string& field, const proto::Deformation& d, SolidShapes& out) {
  const std::vector<Vec3> normals = normals_of(out.surface);
  for (int k = 0; k < d.inflate_size(); ++k) {
    std::vector<Vec3> corners = out.surface.corners;
    for (std::size_t i = 0; i < corners.size(); ++i) corners[i] += d.inflate(k).distance_m() * normals[i];
    if (d.inflate(k).distance_m() != 0.0)
      check_shape(scene, fmt::format("{}.inflate[{}].distance_m", field, k),
                  fmt::format("is {} m, too far for this surface", d.inflate(k).distance_m()), corners, out.surface,
                  "give a smaller distance");
    if (out.times.empty() && d.inflate(k).time_s() > 0.0)
      out.times.push_back(0.0), out.corners.push_back(out.surface.corners);
    out.times.push_back(d.inflate(k).time_s()), out.corners.push_back(std::move(corners));
  }
}

// Throws Error where a file has other points or faces than the first one.
void check_faces(const MeshFile& first, const MeshFile& file) {
  const auto differs = [&](const std::string& what) {
    file.fail(fmt::format("{}; all shapes of a body have the points and faces of its mesh, in one order", what));
  };
  if (file.points.size() != first.points.size())
    differs(fmt::format("has {} points, and '{}' has {}", file.points.size(), first.path, first.points.size()));
  if (file.polygons.size() != first.polygons.size())
    differs(fmt::format("has {} faces, and '{}' has {}", file.polygons.size(), first.path, first.polygons.size()));
  for (std::size_t k = 0; k < file.polygons.size(); ++k)
    if (file.polygons[k].corners != first.polygons[k].corners)
      differs(fmt::format("has in {} {} a face of other points than '{}' in {} {}", file.place, file.polygons[k].line,
                          first.path, first.place, first.polygons[k].line));
}

// The samples of a cache; the first one is the surface at time 0.
void add_cached(const LoadedScene& scene, const std::string& field, const proto::PointCache& m, const MeshFile& first,
                const std::vector<int>& point, SolidShapes& out) {
  PointSamples samples = read_point_cache(scene, field, m, first);
  for (std::size_t k = 0; k < samples.points.size(); ++k) {
    std::vector<Vec3> corners;
    for (const int i : point) corners.push_back(samples.points[k][i]);
    check_shape(scene, field + ".path", fmt::format("'{}': sample {} is no shape of this body", m.path(), k + 1),
                corners, out.surface, "mend that in the animation");
    samples.points[k] = {};
    out.times.push_back(samples.times[k]), out.corners.push_back(std::move(corners));
  }
  out.surface.corners = out.corners.front();
}

}  // namespace

SolidShapes read_shapes(const LoadedScene& scene, const std::string& field, const proto::Body& body) {
  const MeshFile first = read_mesh_file(scene, field + ".mesh", body.mesh());
  SolidShapes out;
  try {
    out.surface = closed_surface(first.points, first.polygons, first.place);
  } catch (const Error& e) {
    scene.fail(field + ".mesh.path", fmt::format("'{}' {}", body.mesh().path(), e.what()));
  }
  const proto::Deformation& d = body.deformation();
  if (d.inflate_size() > 0) {
    add_inflated(scene, field + ".deformation", d, out);
    return out;
  }
  const std::vector<int> point = points_of(out.surface, first.points);
  if (d.has_cache()) {
    add_cached(scene, field + ".deformation.cache", d.cache(), first, point, out);
    return out;
  }
  out.times.push_back(0.0), out.corners.push_back(out.surface.corners);
  for (int k = 0; k < d.shapes_size(); ++k) {
    proto::Mesh mesh = body.mesh();
    mesh.set_path(d.shapes(k).path());
    const std::string at = fmt::format("{}.deformation.shapes[{}]", field, k);
    const MeshFile file = read_mesh_file(scene, at, mesh);
    check_faces(first, file);
    std::vector<Vec3> corners;
    for (const int i : point) corners.push_back(file.points[i]);
    check_shape(scene, at + ".path", fmt::format("'{}' is no shape of this body", mesh.path()), corners, out.surface,
                "mend that in the file");
    out.times.push_back(d.shapes(k).time_s()), out.corners.push_back(std::move(corners));
  }
  return out;
}

}  // namespace sunder::scene
