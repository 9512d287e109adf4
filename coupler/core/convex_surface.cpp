#include "coupler/core/convex_surface.h"

#include <algorithm>
#include <array>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

namespace sunder {

double enclosed_volume(const Surface& s) {
  double volume = 0.0;
  for (const auto& [i, j, k] : s.triangles)
    volume += (s.corners[i] - s.corners[0]).dot((s.corners[j] - s.corners[0]).cross(s.corners[k] - s.corners[0])) / 6.0;
  return volume;
}

Surface convex_surface(const std::vector<Vec3>& points) {
  using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
  std::vector<Point> in;
  in.reserve(points.size());
  for (const Vec3& p : points) in.emplace_back(p.x(), p.y(), p.z());
  CGAL::Surface_mesh<Point> mesh;
  CGAL::convex_hull_3(in.begin(), in.end(), mesh);
  if (mesh.is_empty() || !CGAL::is_closed(mesh)) return {};  // of flat points it is a polygon
  // CGAL's order follows addresses, which differ from run to run. Order by coordinates, so that runs repeat.
  std::vector<CGAL::Surface_mesh<Point>::Vertex_index> order(mesh.vertices().begin(), mesh.vertices().end());
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return mesh.point(a) < mesh.point(b); });
  Surface s;
  std::vector<int> place_of(mesh.number_of_vertices());
  for (const auto v : order) {
    place_of[v.idx()] = static_cast<int>(s.corners.size());
    s.corners.emplace_back(mesh.point(v).x(), mesh.point(v).y(), mesh.point(v).z());
  }
  for (const auto f : mesh.faces()) {
    std::array<int, 3> corners{};
    int n = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f)))
      if (n < 3) corners[n++] = place_of[v.idx()];
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    s.triangles.push_back(corners);
  }
  std::sort(s.triangles.begin(), s.triangles.end());
  return s;
}

}  // namespace sunder
