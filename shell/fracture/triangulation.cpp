#include "shell/fracture/triangulation.h"

#include <algorithm>
#include <map>
#include <numeric>

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/convex_hull_2.h>

namespace sunder::shell {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<int, Kernel>;
using FaceInfo = CGAL::Triangulation_face_base_with_info_2<int, Kernel>;
using FaceBase = CGAL::Constrained_triangulation_face_base_2<Kernel, FaceInfo>;
using Data = CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>;
using Cdt = CGAL::Constrained_Delaunay_triangulation_2<Kernel, Data, CGAL::Exact_predicates_tag>;
using Point = Kernel::Point_2;

Point point(const Vec2& p) { return {p.x(), p.y()}; }

// The part of ab inside the box; false where there is none.
bool clip(Vec2& a, Vec2& b, const Vec2& low, const Vec2& high) {
  double t0 = 0.0, t1 = 1.0;
  const Vec2 from = a, d = b - a;
  for (int k = 0; k < 2; ++k) {
    for (const auto& [distance, slope] : {std::pair{from[k] - low[k], d[k]}, std::pair{high[k] - from[k], -d[k]}}) {
      if (slope == 0.0 && distance < 0.0) return false;
      if (slope == 0.0) continue;
      const double t = -distance / slope;
      if (slope > 0.0)
        t0 = std::max(t0, t);
      else
        t1 = std::min(t1, t);
    }
  }
  if (t0 >= t1) return false;
  if (t1 < 1.0) b = (from + t1 * d).cwiseMax(low).cwiseMin(high);
  if (t0 > 0.0) a = (from + t0 * d).cwiseMax(low).cwiseMin(high);
  return true;
}

struct DisjointSets {
  std::vector<int> parent;
  explicit DisjointSets(int n) : parent(n) { std::iota(parent.begin(), parent.end(), 0); }
  int root(int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  }
  void join(int a, int b) {
    a = root(a), b = root(b);
    parent[std::max(a, b)] = std::min(a, b);
  }
};

}  // namespace

double triangle_area(const Vec2& a, const Vec2& b, const Vec2& c) { return 0.5 * orientation(a, b, c); }

Triangulation triangulate(const KnotVector& u, const KnotVector& v, const CrackGraph& cracks,
                          const std::vector<Vec2>& queries, double spacing, double crumb) {
  Cdt cdt;
  const Vec2 low(u.begin(), v.begin()), high(u.end(), v.end());
  const Vec2 corners[4] = {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
  for (int k = 0; k < 4; ++k) cdt.insert_constraint(point(corners[k]), point(corners[(k + 1) % 4]));
  for (const CrackEdge& e : cracks.edges()) {
    Vec2 a = e.a, b = e.b;
    if (clip(a, b, low, high) && (b - a).norm() > 1e-9 * spacing) cdt.insert_constraint(point(a), point(b));
  }
  for (int j = 0; j <= v.spans(); ++j)
    for (int i = 0; i <= u.spans(); ++i) {
      const Vec2 p(i < u.spans() ? u.span_begin(i) : u.end(), j < v.spans() ? v.span_begin(j) : v.end());
      bool crowded = false;  // a vertex almost on a crack makes slivers
      cracks.near(p, p, 0.15 * spacing, [&](int e) {
        Vec2 foot;
        crowded = cracks.distance(p, e, foot) < 0.15 * spacing;
        return !crowded;
      });
      if (!crowded) cdt.insert(point(p));
    }
  Triangulation t;
  for (auto it = cdt.finite_vertices_begin(); it != cdt.finite_vertices_end(); ++it) {
    it->info() = static_cast<int>(t.vertices.size());
    t.vertices.emplace_back(it->point().x(), it->point().y());
  }
  for (auto it = cdt.all_faces_begin(); it != cdt.all_faces_end(); ++it) it->info() = -1;
  for (auto it = cdt.finite_faces_begin(); it != cdt.finite_faces_end(); ++it) {
    it->info() = static_cast<int>(t.triangles.size());
    t.triangles.push_back({it->vertex(0)->info(), it->vertex(1)->info(), it->vertex(2)->info()});
  }
  const int n = static_cast<int>(t.triangles.size());
  t.neighbours.resize(n), t.crack.resize(n);
  std::vector<std::array<int, 3>> across(n);
  DisjointSets sets(n);
  for (auto it = cdt.finite_faces_begin(); it != cdt.finite_faces_end(); ++it)
    for (int k = 0; k < 3; ++k) {
      const int i = it->info(), other = it->neighbor(k)->info();
      const bool constrained = it->is_constrained(k);
      across[i][k] = other;
      t.neighbours[i][k] = constrained ? -1 : other;
      t.crack[i][k] = constrained && other >= 0;
      if (!constrained && other >= 0) sets.join(i, other);
    }
  // crumbs that joins leave where they cross what they join: part of the largest piece beside them
  std::vector<double> area(n, 0.0);
  const auto area_of = [&](int i) {
    const auto& c = t.triangles[i];
    return triangle_area(t.vertices[c[0]], t.vertices[c[1]], t.vertices[c[2]]);
  };
  for (int i = 0; i < n; ++i) area[sets.root(i)] += area_of(i);
  std::map<int, int> largest;
  for (int i = 0; i < n; ++i)
    for (const int other : across[i]) {
      const int own = sets.root(i);
      if (other < 0 || area[own] >= crumb || sets.root(other) == own) continue;
      const int beside = sets.root(other);
      auto [it, fresh] = largest.try_emplace(own, beside);
      if (!fresh && area[beside] > area[it->second]) it->second = beside;
    }
  for (const auto& [own, beside] : largest) sets.join(own, beside);
  t.piece.assign(n, -1);
  std::vector<int> number(n, -1);
  for (int i = 0; i < n; ++i) {
    const int root = sets.root(i);
    if (number[root] < 0) number[root] = t.pieces++;
    t.piece[i] = number[root];
  }
  Cdt::Face_handle hint;
  for (const Vec2& q : queries) {
    const Vec2 inside =
        q.cwiseMax(low + Vec2::Constant(1e-9 * spacing)).cwiseMin(high - Vec2::Constant(1e-9 * spacing));
    const auto face = cdt.locate(point(inside), hint);
    hint = face;
    t.owner.push_back(face->info() >= 0 ? t.piece[face->info()] : -1);
  }
  return t;
}

std::vector<std::vector<Vec2>> convex_parts(const Triangulation& t, int piece, double tolerance) {
  struct Polygon {
    std::vector<Vec2> hull;
    double area, hull_area;
  };
  // outline triangulation: constraints are the edges where the piece ends
  Cdt cdt;
  double whole = 0.0;
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    if (t.piece[i] != piece) continue;
    const auto& c = t.triangles[i];
    whole += triangle_area(t.vertices[c[0]], t.vertices[c[1]], t.vertices[c[2]]);
  }
  std::map<std::pair<int, int>, int> edges;  // undirected edge -> how many of the piece's triangles have it
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    if (t.piece[i] == piece)
      for (int k = 0; k < 3; ++k) {
        const int a = t.triangles[i][(k + 1) % 3], b = t.triangles[i][(k + 2) % 3];
        ++edges[{std::min(a, b), std::max(a, b)}];
      }
  for (const auto& [edge, count] : edges)
    if (count == 1) cdt.insert_constraint(point(t.vertices[edge.first]), point(t.vertices[edge.second]));
  for (auto it = cdt.all_faces_begin(); it != cdt.all_faces_end(); ++it) it->info() = -1;
  // inside by parity of constrained edges crossed from infinity
  std::vector<Cdt::Face_handle> front{cdt.infinite_face()};
  cdt.infinite_face()->info() = 0;
  while (!front.empty()) {
    const auto face = front.back();
    front.pop_back();
    for (int k = 0; k < 3; ++k) {
      const auto next = face->neighbor(k);
      if (next->info() >= 0) continue;
      next->info() = face->info() + (face->is_constrained(k) ? 1 : 0);
      front.push_back(next);
    }
  }
  std::vector<Polygon> polygons;
  std::map<Cdt::Face_handle, int> number;
  std::vector<std::pair<int, int>> pairs;
  for (auto it = cdt.finite_faces_begin(); it != cdt.finite_faces_end(); ++it) {
    if (it->info() % 2 == 0) continue;
    Polygon p;
    for (int k = 0; k < 3; ++k) p.hull.emplace_back(it->vertex(k)->point().x(), it->vertex(k)->point().y());
    p.area = p.hull_area = triangle_area(p.hull[0], p.hull[1], p.hull[2]);
    number[it] = static_cast<int>(polygons.size());
    polygons.push_back(std::move(p));
  }
  for (auto it = cdt.finite_faces_begin(); it != cdt.finite_faces_end(); ++it)
    for (int k = 0; k < 3 && number.count(it); ++k)
      if (!it->is_constrained(k) && number.count(it->neighbor(k)) && number[it] < number[it->neighbor(k)])
        pairs.push_back({number[it], number[it->neighbor(k)]});
  std::sort(pairs.begin(), pairs.end());
  DisjointSets sets(static_cast<int>(polygons.size()));
  const auto joined = [&](const Polygon& a, const Polygon& b) {
    std::vector<Point> points, hull;
    for (const auto* p : {&a, &b})
      for (const Vec2& q : p->hull) points.push_back(point(q));
    CGAL::convex_hull_2(points.begin(), points.end(), std::back_inserter(hull));
    Polygon r;
    for (const Point& q : hull) r.hull.emplace_back(q.x(), q.y());
    r.area = a.area + b.area, r.hull_area = 0.0;
    for (std::size_t k = 1; k + 1 < r.hull.size(); ++k)
      r.hull_area += triangle_area(r.hull[0], r.hull[k], r.hull[k + 1]);
    return r;
  };
  for (bool again = true; again;) {  // the merge that adds least, as long as one adds little
    again = false;
    double best = tolerance;
    std::pair<int, int> which;
    for (const auto& [a, b] : pairs) {
      const int ra = sets.root(a), rb = sets.root(b);
      if (ra == rb) continue;
      const Polygon r = joined(polygons[ra], polygons[rb]);
      if (r.hull_area - r.area < best) best = r.hull_area - r.area, which = {ra, rb}, again = true;
    }
    if (!again) break;
    const int keep = std::min(which.first, which.second), other = std::max(which.first, which.second);
    polygons[keep] = joined(polygons[keep], polygons[other]);
    sets.join(keep, other);
  }
  std::vector<std::vector<Vec2>> parts;
  for (std::size_t i = 0; i < polygons.size(); ++i)
    if (sets.root(static_cast<int>(i)) == static_cast<int>(i) && polygons[i].area > 1e-6 * whole)
      parts.push_back(polygons[i].hull);
  return parts;
}

}  // namespace sunder::shell
