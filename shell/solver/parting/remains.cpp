#include "shell/solver/parting/remains.h"

#include <algorithm>
#include <limits>

#include "shell/fracture/outline.h"

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

// Both faces of the surface where it stands, over a parameter.
struct Faces {
  Vec3 low, high, normal;
};
Faces faces_at(const ShellModel& m, const ShellState& s, const Vec2& p) {
  const SurfacePoint q = surface(m, s, p);
  const Vec3 n = q.u.cross(q.v).normalized();
  return {q.x - 0.5 * m.thickness * n, q.x + 0.5 * m.thickness * n, n};
}

bool is_torn(double apart, double at_rest, double thickness) { return apart > kNoSurface * at_rest + thickness; }

using Polygon = std::vector<Vec2>;  // convex, of parameters

// The direction in which the surface over a box bends more, 0 or 1; the longer one where it bends alike or is no
// number.
int bent_along(const ShellModel& m, const ShellState& s, const Eigen::AlignedBox2d& box) {
  double bend[2];
  for (const int d : {0, 1}) {
    Vec2 low = box.center(), high = box.center();
    low[d] = box.min()[d], high[d] = box.max()[d];
    bend[d] = (faces_at(m, s, high).normal - faces_at(m, s, low).normal).norm();
  }
  const int longer = box.sizes().y() > box.sizes().x() ? 1 : 0;
  return bend[1 - longer] > bend[longer] && box.sizes()[1 - longer] > 0.5 * m.spacing ? 1 - longer : longer;
}

// Halves of a polygon, by the line across the middle of direction d.
std::pair<Polygon, Polygon> halves_of(const Polygon& polygon, const Eigen::AlignedBox2d& box, int d) {
  const double middle = box.center()[d];
  std::pair<Polygon, Polygon> out;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 &p = polygon[i], &next = polygon[(i + 1) % polygon.size()];
    if (p[d] <= middle) out.first.push_back(p);
    if (p[d] >= middle) out.second.push_back(p);
    if ((p[d] - middle) * (next[d] - middle) < 0.0) {
      const Vec2 q = p + (middle - p[d]) / (next[d] - p[d]) * (next - p);
      out.first.push_back(q), out.second.push_back(q);
    }
  }
  return out;
}

bool holds(const Polygon& polygon, const Vec2& p) {
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 along = polygon[(i + 1) % polygon.size()] - polygon[i], to = p - polygon[i];
    if (along.x() * to.y() - along.y() * to.x() < 0.0) return false;
  }
  return true;
}

// Tests whether the surface over the polygon is within kBentPiece of a plane, at its corners and on a grid of spacings.
bool is_flat(const ShellModel& m, const ShellState& s, const Polygon& polygon) {
  std::vector<Vec2> at = polygon;
  Eigen::AlignedBox2d box;
  for (const Vec2& p : polygon) box.extend(p);
  for (double u = box.min().x() + 0.5 * m.spacing; u < box.max().x(); u += m.spacing)
    for (double v = box.min().y() + 0.5 * m.spacing; v < box.max().y(); v += m.spacing)
      if (holds(polygon, {u, v})) at.emplace_back(u, v);
  std::vector<Faces> faces;
  Vec3 normal = Vec3::Zero();
  for (const Vec2& p : at) {
    faces.push_back(faces_at(m, s, p));
    if (!faces.back().low.allFinite() || !faces.back().high.allFinite()) return false;
    normal += faces.back().normal;
  }
  normal.normalize();
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Faces& f : faces) {
    const double height = normal.dot(0.5 * (f.low + f.high));
    low = std::min(low, height), high = std::max(high, height);
  }
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const std::size_t j = (i + 1) % polygon.size();
    if (is_torn((faces[i].low - faces[j].low).norm(), (polygon[i] - polygon[j]).norm(), m.thickness)) return false;
  }
  return high - low <= kBentPiece * m.thickness;
}

double area_of(const Polygon& polygon) {
  double twice = 0.0;
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    const Vec2 a = polygon[i - 1] - polygon[0], b = polygon[i] - polygon[0];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * twice;
}

// Adds convex parts of a bent piece, in world coordinates: those of its outline, halved until each is flat. What is no
// larger than half a spacing is taken as it is, and left out where it is torn.
void add_bent_parts(const ShellModel& m, const ShellState& s, const Outline& outline, ConvexShape& shape) {
  std::vector<Polygon> open = convex_parts(outline, kPartTolerance * m.spacing * m.spacing);
  double whole = 0.0;
  for (const Polygon& polygon : open) whole += area_of(polygon);
  while (!open.empty()) {
    const Polygon polygon = std::move(open.back());
    open.pop_back();
    if (area_of(polygon) <= kLeastPart * whole) continue;  // no engine takes a body's flat parts
    Eigen::AlignedBox2d box;
    for (const Vec2& p : polygon) box.extend(p);
    const bool small = box.sizes().maxCoeff() <= 0.5 * m.spacing;
    if (!is_flat(m, s, polygon) && !small) {
      auto [first, second] = halves_of(polygon, box, bent_along(m, s, box));
      open.push_back(std::move(first)), open.push_back(std::move(second));
      continue;
    }
    std::vector<Vec3> corners;
    bool torn = false;
    for (const Vec2& p : polygon) {
      const Faces f = faces_at(m, s, p);
      torn = torn || !f.low.allFinite() || !f.high.allFinite() ||
             (!corners.empty() &&
              is_torn((f.low - corners[corners.size() - 2]).norm(), box.diagonal().norm(), m.thickness));
      corners.push_back(f.low), corners.push_back(f.high);
    }
    if (!torn) shape.parts.push_back(std::move(corners));
  }
}

// Draws a prism of each triangle, in world coordinates.
void draw_prisms(const Triangulation& t, const PresentShape& at, double thickness, DrawnMesh& drawn) {
  const auto finite = [&](int v) { return at.low[v].allFinite() && at.high[v].allFinite(); };
  const auto torn = [&](int a, int b) {  // parameters are lengths
    return is_torn((at.low[a] - at.low[b]).norm(), (t.vertices[a] - t.vertices[b]).norm(), thickness);
  };
  std::vector<int> number(t.vertices.size(), -1);
  for (const int i : at.triangles) {
    const auto& c = t.triangles[i];
    if (!finite(c[0]) || !finite(c[1]) || !finite(c[2]) || torn(c[0], c[1]) || torn(c[1], c[2]) || torn(c[2], c[0]))
      continue;
    for (const int v : c) {
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
        add_bent_parts(m, s, outline_of(t, p.number), shape);
        draw_prisms(t, at, m.thickness, out.drawn);
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
