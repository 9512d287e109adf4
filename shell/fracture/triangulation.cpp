#include "shell/fracture/triangulation.h"

#include <algorithm>
#include <map>

#include "shell/fracture/cdt.h"
#include "shell/fracture/constants.h"

namespace sunder::shell {
namespace {

// Clips ab to the box; false where no part of it is inside.
bool clip(Vec2& a, Vec2& b, const Vec2& low, const Vec2& high) {
  struct Hit {
    double t;
    int axis = 0;
    double side = 0.0;
  } first{0.0}, last{1.0};
  const Vec2 from = a, d = b - a;
  for (int k = 0; k < 2; ++k)
    for (const bool upper : {false, true}) {
      const double side = upper ? high[k] : low[k];
      const double distance = upper ? side - from[k] : from[k] - side, slope = upper ? -d[k] : d[k];
      if (slope == 0.0 && distance < 0.0) return false;
      if (slope == 0.0) continue;
      const double t = -distance / slope;
      if (slope > 0.0 && t > first.t) first = {t, k, side};
      if (slope < 0.0 && t < last.t) last = {t, k, side};
    }
  if (first.t >= last.t) return false;
  const auto at = [&](const Hit& hit) {
    Vec2 p = (from + hit.t * d).cwiseMax(low).cwiseMin(high);
    p[hit.axis] = hit.side;  // exactly: an end just inside the border would leave both sides connected
    return p;
  };
  if (last.t < 1.0) b = at(last);
  if (first.t > 0.0) a = at(first);
  return true;
}

}  // namespace

double triangle_area(const Vec2& a, const Vec2& b, const Vec2& c) { return 0.5 * orientation(a, b, c); }

Triangulation triangulate(const KnotVector& u, const KnotVector& v, const CrackGraph& cracks,
                          const std::vector<Vec2>& queries, double spacing, double sliver,
                          std::span<const Eigen::AlignedBox2d> knots_in) {
  Cdt cdt;
  const Vec2 low(u.begin(), v.begin()), high(u.end(), v.end());
  const Vec2 corners[4] = {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
  for (int k = 0; k < 4; ++k) cdt.insert_constraint(point(corners[k]), point(corners[(k + 1) % 4]));
  // Cracks share vertices, and a vertex is near the one before: this saves a walk through the whole to find its place.
  std::vector<Cdt::Vertex_handle> known(cracks.vertices().size());
  Cdt::Vertex_handle last;
  const auto on_border = [&](Vec2 p) {
    for (int k = 0; k < 2; ++k)
      for (const double border : {low[k], high[k]})
        if (std::abs(p[k] - border) < kBorderTolerance * spacing) p[k] = border;
    return p;
  };
  const auto inserted = [&](int vertex, const Vec2& p) {
    const bool whole = p == cracks.vertices()[vertex];
    if (whole && known[vertex] != Cdt::Vertex_handle()) return last = known[vertex];
    last = cdt.insert(point(p), last != Cdt::Vertex_handle() ? last->face() : Cdt::Face_handle());
    return whole ? known[vertex] = last : last;
  };
  for (const CrackEdge& e : cracks.edges()) {
    Vec2 a = on_border(e.a), b = on_border(e.b);
    if (!clip(a, b, low, high) || !((b - a).norm() > 1e-9 * spacing)) continue;
    const Cdt::Vertex_handle from = inserted(e.from, a), to = inserted(e.to, b);
    if (from != to) cdt.insert_constraint(from, to);
  }
  Cdt::Face_handle beside;  // beside the last vertex, from where the next is soon found
  for (int j = 0; j <= v.spans() && !knots_in.empty(); ++j)
    for (int i = 0; i <= u.spans(); ++i) {
      const Vec2 p(i < u.spans() ? u.span_begin(i) : u.end(), j < v.spans() ? v.span_begin(j) : v.end());
      if (std::none_of(knots_in.begin(), knots_in.end(), [&](const auto& box) { return box.contains(p); })) continue;
      bool crowded = false;  // a vertex almost on a crack makes slivers
      cracks.near(p, p, kKnotClearance * spacing, [&](int e) {
        Vec2 foot;
        crowded = cracks.distance(p, e, foot) < kKnotClearance * spacing;
        return !crowded;
      });
      if (!crowded) beside = cdt.insert(point(p), beside)->face();
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
  const auto cracked = [&](Cdt::Face_handle face, int k) {  // whether a crack runs on an edge of the border
    const auto &a = face->vertex(Cdt::ccw(k))->point(), &b = face->vertex(Cdt::cw(k))->point();
    const Vec2 middle(0.5 * (a.x() + b.x()), 0.5 * (a.y() + b.y()));
    bool found = false;
    Vec2 foot;
    cracks.near(middle, middle, kBorderTolerance * spacing,
                [&](int e) { return found = cracks.distance(middle, e, foot) < kBorderTolerance * spacing, !found; });
    return found;
  };
  for (auto it = cdt.finite_faces_begin(); it != cdt.finite_faces_end(); ++it)
    for (int k = 0; k < 3; ++k) {
      const int i = it->info(), other = it->neighbor(k)->info();
      const bool constrained = it->is_constrained(k);
      across[i][k] = other;
      t.neighbours[i][k] = constrained ? -1 : other;
      t.crack[i][k] = constrained && (other >= 0 || cracked(it, k));
      if (!constrained && other >= 0) sets.join(i, other);
    }
  // slivers that joins leave where they cross a crack: part of the largest piece beside them
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
      if (other < 0 || area[own] >= sliver || sets.root(other) == own) continue;
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
  t.first_of.assign(t.pieces + 1, 0), t.by_piece.resize(n);
  for (const int piece : t.piece) ++t.first_of[piece + 1];
  for (int k = 0; k < t.pieces; ++k) t.first_of[k + 1] += t.first_of[k];
  std::vector<int> next(t.first_of.begin(), t.first_of.end() - 1);
  for (int i = 0; i < n; ++i) t.by_piece[next[t.piece[i]]++] = i;
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

}  // namespace sunder::shell
