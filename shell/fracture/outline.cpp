#include "shell/fracture/outline.h"

#include <algorithm>
#include <functional>
#include <map>
#include <queue>
#include <set>
#include <tuple>

#include <CGAL/convex_hull_2.h>

#include "shell/fracture/cdt.h"
#include "shell/fracture/constants.h"

namespace sunder::shell {

namespace {

struct Edges {
  std::vector<std::pair<int, int>> border, inner;  // vertices; inner: cracks with the piece on both sides
};

Edges edges_of(const Triangulation& t, int piece) {
  struct Seen {
    int triangles = 0;
    bool crack = false;
  };
  std::map<std::pair<int, int>, Seen> seen;  // undirected edge -> triangles of the piece that have it
  for (const int i : t.triangles_of(piece))
    for (int k = 0; k < 3; ++k) {
      const int a = t.triangles[i][(k + 1) % 3], b = t.triangles[i][(k + 2) % 3];
      Seen& edge = seen[{std::min(a, b), std::max(a, b)}];
      ++edge.triangles, edge.crack |= t.crack[i][k] != 0;
    }
  Edges out;
  for (const auto& [edge, found] : seen) {
    if (found.triangles == 1) out.border.push_back(edge);
    if (found.triangles == 2 && found.crack) out.inner.push_back(edge);
  }
  return out;
}

Outline outline_by(const Triangulation& t, const Edges& edges) {
  Cdt cdt;
  for (const auto& [a, b] : edges.border) cdt.insert_constraint(point(t.vertices[a]), point(t.vertices[b]));
  std::set<std::pair<Cdt::Vertex_handle, Cdt::Vertex_handle>> inner;  // both ways
  for (const auto& [a, b] : edges.inner) {
    const Cdt::Vertex_handle from = cdt.insert(point(t.vertices[a])), to = cdt.insert(point(t.vertices[b]));
    cdt.insert_constraint(from, to);
    inner.emplace(from, to), inner.emplace(to, from);
  }
  for (auto it = cdt.all_faces_begin(); it != cdt.all_faces_end(); ++it) it->info() = -1;
  const auto is_inner = [&](Cdt::Face_handle face, int k) {
    return inner.contains({face->vertex(cdt.ccw(k)), face->vertex(cdt.cw(k))});
  };
  // inside by parity of edges of the border crossed from infinity
  std::vector<Cdt::Face_handle> front{cdt.infinite_face()};
  cdt.infinite_face()->info() = 0;
  while (!front.empty()) {
    const auto face = front.back();
    front.pop_back();
    for (int k = 0; k < 3; ++k) {
      const auto next = face->neighbor(k);
      if (next->info() >= 0) continue;
      next->info() = face->info() + (face->is_constrained(k) && !is_inner(face, k) ? 1 : 0);
      front.push_back(next);
    }
  }
  Outline out;
  for (auto it = cdt.finite_vertices_begin(); it != cdt.finite_vertices_end(); ++it) {
    it->info() = static_cast<int>(out.vertices.size());
    out.vertices.emplace_back(it->point().x(), it->point().y());
  }
  for (auto it = cdt.finite_faces_begin(); it != cdt.finite_faces_end(); ++it) {
    if (it->info() % 2 == 0) continue;
    out.triangles.push_back({it->vertex(0)->info(), it->vertex(1)->info(), it->vertex(2)->info()});
    for (int k = 0; k < 3; ++k)
      if (it->neighbor(k)->info() % 2 == 0 || is_inner(it, k))
        out.border.push_back({it->vertex((k + 1) % 3)->info(), it->vertex((k + 2) % 3)->info()});
  }
  return out;
}

}  // namespace

Outline outline_of(const Triangulation& t, int piece) { return outline_by(t, {edges_of(t, piece).border, {}}); }

bool has_inner_cracks(const Triangulation& t, int piece) { return !edges_of(t, piece).inner.empty(); }

Outline outline_with_cracks(const Triangulation& t, int piece) { return outline_by(t, edges_of(t, piece)); }

std::vector<std::vector<Vec2>> convex_parts(const Outline& outline, double tolerance) {
  struct Polygon {
    std::vector<Vec2> hull;
    double area, hull_area;
  };
  std::vector<Polygon> polygons;
  std::vector<std::pair<int, int>> pairs;
  std::map<std::pair<int, int>, int> beside;  // undirected edge -> the triangle seen first on it
  double whole = 0.0;
  for (const auto& c : outline.triangles) {
    Polygon p;
    for (const int k : c) p.hull.push_back(outline.vertices[k]);
    p.area = p.hull_area = triangle_area(p.hull[0], p.hull[1], p.hull[2]);
    whole += p.area;
    const int own = static_cast<int>(polygons.size());
    for (int k = 0; k < 3; ++k) {
      const auto edge = std::minmax(c[k], c[(k + 1) % 3]);
      const auto [it, fresh] = beside.try_emplace({edge.first, edge.second}, own);
      if (!fresh) pairs.push_back({it->second, own});
    }
    polygons.push_back(std::move(p));
  }
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
  // The merge that adds least, while it adds little. Pairs wait in a queue with what they add; a pair is asked again
  // when one of its polygons has grown.
  std::vector<int> grown(polygons.size(), 0);
  std::vector<std::vector<int>> pairs_of(polygons.size());
  struct Waiting {
    double added;
    int pair, first_grown, second_grown;
    bool operator>(const Waiting& o) const { return std::tie(added, pair) > std::tie(o.added, o.pair); }
  };
  std::priority_queue<Waiting, std::vector<Waiting>, std::greater<>> queue;
  const auto ask = [&](int pair) {
    const int a = sets.root(pairs[pair].first), b = sets.root(pairs[pair].second);
    if (a == b) return;
    const Polygon r = joined(polygons[a], polygons[b]);
    if (r.hull_area - r.area < tolerance) queue.push({r.hull_area - r.area, pair, grown[a], grown[b]});
  };
  for (int k = 0; k < static_cast<int>(pairs.size()); ++k) {
    pairs_of[pairs[k].first].push_back(k), pairs_of[pairs[k].second].push_back(k);
    ask(k);
  }
  while (!queue.empty()) {
    const Waiting best = queue.top();
    queue.pop();
    const int a = sets.root(pairs[best.pair].first), b = sets.root(pairs[best.pair].second);
    if (a == b || grown[a] != best.first_grown || grown[b] != best.second_grown) continue;
    const int keep = std::min(a, b), other = std::max(a, b);
    polygons[keep] = joined(polygons[keep], polygons[other]);
    sets.join(keep, other);
    grown[keep] = std::max(grown[keep], grown[other]) + 1;
    std::vector<int>& own = pairs_of[keep];
    own.insert(own.end(), pairs_of[other].begin(), pairs_of[other].end());
    pairs_of[other].clear();
    std::erase_if(own, [&](int k) { return sets.root(pairs[k].first) == sets.root(pairs[k].second); });
    std::sort(own.begin(), own.end());
    own.erase(std::unique(own.begin(), own.end()), own.end());
    for (const int k : own) ask(k);
  }
  std::vector<std::vector<Vec2>> parts;
  for (std::size_t i = 0; i < polygons.size(); ++i)
    if (sets.root(static_cast<int>(i)) == static_cast<int>(i) && polygons[i].area > kLeastPart * whole)
      parts.push_back(polygons[i].hull);
  return parts;
}

}  // namespace sunder::shell
