#include "shell/solver/parting/bent_piece.h"

#include <algorithm>
#include <limits>

namespace sunder::shell {
namespace {

using Polygon = std::vector<Vec2>;  // convex, of parameters

bool is_torn(const PieceSurface& surface, double apart, double at_rest, double thickness) {
  return apart > surface.torn * at_rest + thickness;
}

// The direction in which the surface over a box bends more, 0 or 1; the longer one where it bends alike or is no
// number.
int bent_along(const ShellModel& m, const PieceSurface& surface, const Eigen::AlignedBox2d& box) {
  double bend[2];
  for (const int d : {0, 1}) {
    Vec2 low = box.center(), high = box.center();
    low[d] = box.min()[d], high[d] = box.max()[d];
    bend[d] = (surface.at(high).normal - surface.at(low).normal).norm();
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
bool is_flat(const ShellModel& m, const PieceSurface& surface, const Polygon& polygon) {
  std::vector<Vec2> at = polygon;
  Eigen::AlignedBox2d box;
  for (const Vec2& p : polygon) box.extend(p);
  for (double u = box.min().x() + 0.5 * m.spacing; u < box.max().x(); u += m.spacing)
    for (double v = box.min().y() + 0.5 * m.spacing; v < box.max().y(); v += m.spacing)
      if (holds(polygon, {u, v})) at.emplace_back(u, v);
  std::vector<Faces> faces;
  Vec3 normal = Vec3::Zero();
  for (const Vec2& p : at) {
    faces.push_back(surface.at(p));
    if (!faces.back().finite()) return false;
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
    if (is_torn(surface, (faces[i].low - faces[j].low).norm(), (polygon[i] - polygon[j]).norm(), m.thickness))
      return false;
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

}  // namespace

bool is_bent(const PieceSurface& surface, const Triangulation& t, int piece, double most) {
  std::vector<char> seen(t.vertices.size(), 0);
  Vec3 normal = Vec3::Zero(), centre = Vec3::Zero();
  std::vector<Vec3> middles;
  for (const int i : t.triangles_of(piece))
    for (const int v : t.triangles[i]) {
      if (seen[v]) continue;
      seen[v] = 1;
      const Faces f = surface.at(t.vertices[v]);
      middles.push_back(0.5 * (f.low + f.high));
      normal += f.normal, centre += middles.back();
    }
  if (middles.empty()) return false;
  normal.normalize(), centre /= static_cast<double>(middles.size());
  return std::any_of(middles.begin(), middles.end(),
                     [&](const Vec3& x) { return !(std::abs(normal.dot(x - centre)) <= most); });
}

void add_flat_parts(const ShellModel& m, const PieceSurface& surface, const Outline& outline, ConvexShape& shape) {
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
    if (!is_flat(m, surface, polygon) && !small) {
      auto [first, second] = halves_of(polygon, box, bent_along(m, surface, box));
      open.push_back(std::move(first)), open.push_back(std::move(second));
      continue;
    }
    std::vector<Vec3> corners;
    bool torn = false;
    for (const Vec2& p : polygon) {
      const Faces f = surface.at(p);
      torn = torn || !f.finite() ||
             (!corners.empty() &&
              is_torn(surface, (f.low - corners[corners.size() - 2]).norm(), box.diagonal().norm(), m.thickness));
      corners.push_back(f.low), corners.push_back(f.high);
    }
    if (!torn) shape.parts.push_back(std::move(corners));
  }
}

void draw_prisms(const PieceSurface& surface, const Triangulation& t, int piece, double thickness, DrawnMesh& drawn) {
  std::vector<int> number(t.vertices.size(), -1);  // of the lower face's point in `faces`
  std::vector<Faces> faces;
  std::vector<int> drawn_as;  // the lower face's point in the mesh
  const auto face = [&](int v) -> const Faces& {
    if (number[v] < 0)
      number[v] = static_cast<int>(faces.size()), faces.push_back(surface.at(t.vertices[v])), drawn_as.push_back(-1);
    return faces[number[v]];
  };
  for (const int i : t.triangles_of(piece)) {
    const auto& c = t.triangles[i];
    bool whole = true;
    for (const int v : c) whole = whole && face(v).finite();
    for (int k = 0; k < 3 && whole; ++k) {
      const int a = c[k], b = c[(k + 1) % 3];
      whole = !is_torn(surface, (face(a).low - face(b).low).norm(), (t.vertices[a] - t.vertices[b]).norm(), thickness);
    }
    if (!whole) continue;
    for (const int v : c) {
      if (drawn_as[number[v]] >= 0) continue;
      drawn_as[number[v]] = static_cast<int>(drawn.points.size());
      drawn.points.push_back(face(v).low), drawn.points.push_back(face(v).high);
    }
    const auto low = [&](int k) { return drawn_as[number[c[k]]]; };
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

}  // namespace sunder::shell
