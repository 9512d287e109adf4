#include "shell/solver/parting/pieces.h"

#include "shell/solver/cracking/clamp.h"

namespace sunder::shell {
Eigen::AlignedBox2d domain_of(const ShellModel& m) {
  const auto &u = m.patch.knots_u, &v = m.patch.knots_v;
  return {Vec2(u.begin(), v.begin()), Vec2(u.end(), v.end())};
}

Vec2 drawn_parameter(const ShellModel& m, const Vec2& p) {
  if (m.texture) return m.texture(p);
  const Eigen::AlignedBox2d domain = domain_of(m);
  return (p - domain.min()).cwiseQuotient(domain.sizes());
}

Vec3 drawn_colour(const ShellModel& m, const Vec2& p) { return m.colour ? m.colour(p) : Vec3(Vec3::Ones()); }

Triangulation triangulated(const ShellModel& m, const ShellState& s, std::span<const Eigen::AlignedBox2d> knots_in) {
  std::vector<Vec2> places =
      m.trim.empty() ? m.parameter : m.trim.home;  // a point on a crack belongs to its left side, as for visibility
  for (Vec2& p : places)
    s.cracks.graph.near(p, p, m.spacing, [&](int e) {
      Vec2 foot;
      const CrackEdge& c = s.cracks.graph.edges()[e];
      const Vec2 d = (c.b - c.a).normalized();
      if (s.cracks.graph.distance(p, e, foot) < 1e-9 * m.spacing) p += 1e-6 * m.spacing * Vec2(-d.y(), d.x());
      return true;
    });
  Triangulation t = triangulate(m.patch.knots_u, m.patch.knots_v, s.cracks.graph, places, m.spacing,
                                kSliver * m.spacing * m.spacing, knots_in);
  for (int i = 0; i < m.control_points(); ++i)
    if (m.trim.drops(m.tables.slot(i)) || parted_from_clamp(m, s.cracks.graph, i) >= 0) t.owner[i] = -1;
  return t;
}

namespace {

// Marks the pieces that trim loops cut away, by their largest triangles.
void mark_outside(const ShellModel& m, const Triangulation& t, std::vector<Piece>& pieces) {
  if (m.trim.empty()) return;
  for (Piece& p : pieces) {
    double largest = 0.0;
    for (const int i : t.triangles_of(p.number)) {
      const Vec2 &a = t.vertices[t.triangles[i][0]], &b = t.vertices[t.triangles[i][1]],
                 &c = t.vertices[t.triangles[i][2]];
      const double area = triangle_area(a, b, c);
      if (area > largest) largest = area, p.outside = !m.trim.loops.contains((a + b + c) / 3.0);
    }
  }
}

}  // namespace

std::vector<Piece> pieces_of(const ShellModel& m, const ShellState& s, const Triangulation& t) {
  std::vector<Piece> pieces(t.pieces);
  for (int i = 0; i < t.pieces; ++i) pieces[i].number = i;
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    const auto& c = t.triangles[i];
    pieces[t.piece[i]].area += triangle_area(t.vertices[c[0]], t.vertices[c[1]], t.vertices[c[2]]);
  }
  mark_outside(m, t, pieces);
  std::vector<int> detached(t.pieces, 0);
  std::vector<char> anchored(m.tables.component_stride, 0);
  for (const int slot : m.constraints.anchors) anchored[slot] = 1;
  for (int i = 0; i < m.control_points(); ++i) {
    if (m.trim.drops(m.tables.slot(i))) continue;
    if (t.owner[i] < 0) {
      // for a corner, the point beside it may be parted too
      const int beside = parted_from_clamp(m, s.cracks.graph, i);
      if (beside >= 0 && t.owner[beside] >= 0) pieces[t.owner[beside]].parted = true;
      continue;
    }
    Piece& p = pieces[t.owner[i]];
    p.control_points.push_back(i);
    p.held = p.held || anchored[m.tables.slot(i)];
    detached[t.owner[i]] += s.motion.detached[m.tables.slot(i)];
  }
  for (Piece& p : pieces) p.handed_off = p.outside || (!p.control_points.empty() && detached[p.number] > 0);
  for (const Interlock& lock : s.cracks.interlocks) {
    if (!lock.holds) continue;
    const int a = t.owner[m.tables.control_point(lock.plus.front().slot)],
              b = t.owner[m.tables.control_point(lock.minus.front().slot)];
    if (a != b && a >= 0 && b >= 0) pieces[a].interlocked = pieces[b].interlocked = true;
  }
  return pieces;
}

}  // namespace sunder::shell
