#include "shell/fracture/medial_axis.h"

#include <algorithm>

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>

#include "coupler/core/disjoint_sets.h"
#include "shell/fracture/cdt.h"
#include "shell/fracture/constants.h"

namespace sunder::shell {
namespace {

using DelaunayData =
    CGAL::Triangulation_data_structure_2<VertexBase, CGAL::Triangulation_face_base_with_info_2<int, Kernel>>;
using Delaunay = CGAL::Delaunay_triangulation_2<Kernel, DelaunayData>;

std::vector<std::vector<int>> walk(const std::vector<std::array<int, 2>>& edges, std::size_t vertices) {
  std::vector<std::vector<int>> at(vertices);  // edges of each vertex
  for (std::size_t e = 0; e < edges.size(); ++e)
    for (const int v : edges[e]) at[v].push_back(static_cast<int>(e));
  std::vector<char> used(edges.size(), 0);
  std::vector<std::vector<int>> lines;
  const auto follow = [&](int start, int edge) {
    std::vector<int> line{start};
    while (!used[edge]) {
      used[edge] = 1;
      line.push_back(edges[edge][0] == line.back() ? edges[edge][1] : edges[edge][0]);
      const auto& next = at[line.back()];
      if (next.size() != 2) break;
      edge = used[next[0]] ? next[1] : next[0];
    }
    lines.push_back(line);
  };
  for (std::size_t v = 0; v < vertices; ++v)
    if (at[v].size() != 2)
      for (const int e : at[v])
        if (!used[e]) follow(static_cast<int>(v), e);
  for (std::size_t e = 0; e < edges.size(); ++e)  // closed loops
    if (!used[e]) follow(edges[e][0], static_cast<int>(e));
  return lines;
}

double length(const MedialAxis& axis, const std::vector<int>& line) {
  double sum = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) sum += (axis.vertices[line[i]] - axis.vertices[line[i - 1]]).norm();
  return sum;
}

}  // namespace

MedialAxis medial_axis(const std::vector<BoundarySample>& seeds, const std::function<bool(const Vec2&)>& inside) {
  MedialAxis axis;
  Delaunay d;
  for (std::size_t i = 0; i < seeds.size(); ++i) d.insert(point(seeds[i].p))->info() = static_cast<int>(i);
  if (d.dimension() < 2) return axis;
  int faces = 0;
  for (auto f = d.all_faces_begin(); f != d.all_faces_end(); ++f) f->info() = faces++;
  // four seeds on a circle, as a lattice has many, make two faces with one Voronoi vertex
  DisjointSets same(faces);
  std::vector<int> number(faces, -1);
  // Each edge between two finite faces, from the one of lower number. CGAL's own iterator takes the one that lies lower
  // in memory: what came out would differ from run to run.
  const auto each_edge = [&](auto&& f) {
    for (auto face = d.finite_faces_begin(); face != d.finite_faces_end(); ++face)
      for (int k = 0; k < 3; ++k) {
        const Delaunay::Face_handle other = face->neighbor(k);
        if (!d.is_infinite(other) && face->info() < other->info()) f(Delaunay::Face_handle(face), k, other);
      }
  };
  each_edge([&](Delaunay::Face_handle face, int k, Delaunay::Face_handle other) {
    const double length2 = d.segment(face, k).squared_length();
    if (CGAL::squared_distance(d.circumcenter(face), d.circumcenter(other)) < kSamePlace * kSamePlace * length2)
      same.join(face->info(), other->info());
  });
  const auto vertex = [&](Delaunay::Face_handle f) {
    int& v = number[same.root(f->info())];
    if (v < 0) {
      const Point c = d.circumcenter(f);
      v = static_cast<int>(axis.vertices.size());
      axis.vertices.emplace_back(c.x(), c.y());
    }
    return v;
  };
  each_edge([&](Delaunay::Face_handle face, int k, Delaunay::Face_handle other) {
    const BoundarySample& a = seeds[face->vertex((k + 1) % 3)->info()];
    const BoundarySample& b = seeds[face->vertex((k + 2) % 3)->info()];
    const Vec2 chord = b.p - a.p;
    if (a.historical || b.historical || a.outward.dot(b.outward) > kFacingSeeds || a.outward.dot(chord) >= 0.0 ||
        b.outward.dot(chord) <= 0.0)
      return;
    const Point p = d.circumcenter(face), q = d.circumcenter(other);
    if (!inside({p.x(), p.y()}) || !inside({q.x(), q.y()})) return;
    const int from = vertex(face), to = vertex(other);
    if (from != to) axis.edges.push_back({from, to});
  });
  return axis;
}

std::vector<std::vector<int>> polylines(const MedialAxis& axis, double spur) {
  std::vector<std::array<int, 2>> edges = axis.edges;
  for (int pass = 0; pass < 2; ++pass) {  // what hung on a spur may be one itself
    std::vector<int> degree(axis.vertices.size(), 0);
    for (const auto& e : edges)
      for (const int v : e) ++degree[v];
    std::vector<std::array<int, 2>> kept;
    for (const auto& line : walk(edges, axis.vertices.size())) {
      const bool loose = (degree[line.front()] == 1) != (degree[line.back()] == 1);
      if (loose && length(axis, line) < spur) continue;
      for (std::size_t i = 1; i < line.size(); ++i) kept.push_back({line[i - 1], line[i]});
    }
    edges = std::move(kept);
  }
  return walk(edges, axis.vertices.size());
}

}  // namespace sunder::shell
