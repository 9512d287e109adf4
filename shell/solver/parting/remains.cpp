#include "shell/solver/parting/remains.h"

#include <algorithm>

namespace sunder::shell {
namespace {

// The surface where it stands, with the functions of the uncut patch.
SurfacePoint surface(const ShellModel& m, const ShellState& s, const Vec2& p) {
  const ShapeFunctions f = m.patch.shape_functions(p);
  SurfacePoint out{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  for (int k = 0; k < f.count(); ++k) {
    const Vec3 x = s.position(f.row(k) * m.tables.stride + f.column(k));
    out.x += f.value[k] * x, out.u += f.u[k] * x, out.v += f.v[k] * x;
  }
  return out;
}

// The present shape of a piece.
struct PresentShape {
  std::vector<int> triangles;
  std::vector<Vec3> low, high;  // of each vertex of the triangulation; unset outside the piece
  bool bent = false;
};

PresentShape present_shape(const ShellModel& m, const ShellState& s, const Triangulation& t, int piece) {
  PresentShape out;
  out.low.resize(t.vertices.size()), out.high.resize(t.vertices.size());
  std::vector<char> seen(t.vertices.size(), 0);
  Vec3 normal = Vec3::Zero(), centre = Vec3::Zero();
  std::vector<Vec3> middles;
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    if (t.piece[i] != piece) continue;
    out.triangles.push_back(static_cast<int>(i));
    for (const int v : t.triangles[i]) {
      if (seen[v]) continue;
      seen[v] = 1;
      const SurfacePoint q = surface(m, s, t.vertices[v]);
      const Vec3 n = q.u.cross(q.v).normalized();
      out.low[v] = q.x - 0.5 * m.thickness * n, out.high[v] = q.x + 0.5 * m.thickness * n;
      normal += n, centre += q.x;
      middles.push_back(q.x);
    }
  }
  if (middles.empty()) return out;
  normal.normalize(), centre /= static_cast<double>(middles.size());
  for (const Vec3& x : middles) out.bent = out.bent || !(std::abs(normal.dot(x - centre)) <= kBentPiece * m.thickness);
  return out;
}

// Makes a prism of each triangle, in world coordinates.
void add_prisms(const Triangulation& t, const PresentShape& at, double thickness, ConvexShape& shape,
                DrawnMesh& drawn) {
  const auto finite = [&](int v) { return at.low[v].allFinite() && at.high[v].allFinite(); };
  const auto torn = [&](int a, int b) {  // parameters are lengths
    return (at.low[a] - at.low[b]).norm() > kNoSurface * (t.vertices[a] - t.vertices[b]).norm() + thickness;
  };
  std::vector<int> number(t.vertices.size(), -1);
  for (const int i : at.triangles) {
    const auto& c = t.triangles[i];
    if (!finite(c[0]) || !finite(c[1]) || !finite(c[2]) || torn(c[0], c[1]) || torn(c[1], c[2]) || torn(c[2], c[0]))
      continue;
    auto& corners = shape.parts.emplace_back();
    for (const int v : c) {
      corners.push_back(at.low[v]), corners.push_back(at.high[v]);
      if (number[v] >= 0) continue;
      number[v] = static_cast<int>(drawn.points.size());
      drawn.points.push_back(at.low[v]), drawn.points.push_back(at.high[v]);
    }
    const auto low = [&](int k) { return number[c[k]]; };
    drawn.triangles.push_back({low(0) + 1, low(1) + 1, low(2) + 1});
    drawn.triangles.push_back({low(0), low(2), low(1)});
    for (int k = 0; k < 3; ++k) {
      const int other = t.neighbours[i][k], a = low((k + 1) % 3), b = low((k + 2) % 3);
      if (other >= 0 && t.piece[other] == t.piece[i]) continue;
      drawn.triangles.push_back({a, b, b + 1});
      drawn.triangles.push_back({a, b + 1, a + 1});
    }
  }
}

}  // namespace

Handoff freeze(const ShellModel& m, ShellState& s, const Triangulation& t, const std::vector<Piece>& pieces,
               BodyId id) {
  Handoff out;
  RigidBody& b = out.body;
  b.id = id, b.name = m.name + "_remains", b.is_static = true;
  b.contact_group = m.contact_group;
  ConvexShape shape;
  for (const Piece& p : pieces)
    if (!p.gone && p.held) {
      std::vector<int> slots;
      for (const int i : p.control_points) slots.push_back(m.tables.slot(i));
      for (int i = 0; i < m.control_points() && p.control_points.empty(); ++i)  // a splinter on an interlayer
        if (!s.motion.detached[m.tables.slot(i)]) slots.push_back(m.tables.slot(i));
      out.area += p.area;
      const PresentShape at = present_shape(m, s, t, p.number);
      if (at.bent) {
        add_prisms(t, at, m.thickness, shape, out.drawn);
        continue;
      }
      Mat3 rotation;
      Vec3 from, to;
      fit_pose(m, s, slots, rotation, from, to);  // at its present place: a hinged pane may have swung
      thicken(m, t, p.number, from - rotation.transpose() * to, rotation, shape, out.drawn);
    }
  b.shape = std::move(shape);
  for (const Piece& p : pieces)
    if (!p.gone) remove_piece(m, s, p);
  return out;
}

}  // namespace sunder::shell
