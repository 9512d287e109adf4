#include "shell/solver/parting/bent_piece.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "coupler/core/dense.h"

#include "shell/fracture/constants.h"

namespace sunder::shell {
namespace {

using Polygon = std::vector<Vec2>;  // convex, of parameters

bool is_torn(const PieceSurface& surface, double apart, double at_rest, double thickness) {
  return apart > surface.torn * at_rest + thickness;
}

// Tests whether half the thickness is a linear function of the place in the mean plane, to `most` [m].
bool tapers_evenly(const std::vector<Faces>& faces, const Vec3& normal, double most) {
  const Vec3 along = normal.unitOrthogonal(), across = normal.cross(along), centre = faces[0].middle();
  Eigen::MatrixX3d place(faces.size(), 3);
  Eigen::VectorXd half(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const Vec3 x = faces[i].middle() - centre;
    place.row(i) << 1.0, along.dot(x), across.dot(x);
    half[i] = 0.5 * (faces[i].high - faces[i].low).norm();
  }
  if (!place.allFinite() || !half.allFinite()) return false;
  const Vec3 fit = shortest_fit(place, half);
  const Eigen::VectorXd off = half - place * fit;
  return off.maxCoeff() - off.minCoeff() <= most;
}

// The direction in which the surface over a box turns more, 0 or 1, or in which a face of a sheet whose thickness
// varies does; the longer one where it turns alike or is no number.
int bent_along(const ShellModel& m, const PieceSurface& surface, const Eigen::AlignedBox2d& box) {
  constexpr int kSections = 4;  // a ring turns as much, though its two ends look alike
  constexpr double kMore = 1e-6;
  double bend[2] = {0.0, 0.0};
  for (const int d : {0, 1}) {
    Vec2 at = box.center();
    at[d] = box.min()[d];
    Vec3 before = surface.at(at).normal;
    double thickness[2] = {m.thickness_at(at), 0.0}, slope = 0.0;  // half of the thickness is on either side
    for (int k = 1; k <= kSections; ++k) {
      at[d] = box.min()[d] + box.sizes()[d] * k / kSections;
      const Vec3 normal = surface.at(at).normal;
      bend[d] += (normal - before).norm(), before = normal;
      if (!m.varies()) continue;
      thickness[1] = m.thickness_at(at);
      const double now = 0.5 * (thickness[1] - thickness[0]) * kSections / box.sizes()[d];
      if (k > 1) bend[d] += std::abs(now - slope);
      slope = now, thickness[0] = thickness[1];
    }
  }
  const int longer = box.sizes().y() > box.sizes().x() ? 1 : 0;
  return bend[1 - longer] > bend[longer] + kMore && box.sizes()[1 - longer] > 0.5 * m.spacing ? 1 - longer : longer;
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

// Where a polygon is looked at: its corners first, then every half spacing along its sides, and a grid of spacings.
std::vector<Vec2> places_on(const ShellModel& m, const Polygon& polygon) {
  std::vector<Vec2> at = polygon;
  Eigen::AlignedBox2d box;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const int parts = std::max(2, static_cast<int>(std::ceil((b - a).norm() / (0.5 * m.spacing))));
    for (int k = 1; k < parts; ++k) at.push_back(a + (b - a) * k / parts);
    box.extend(a);
  }
  for (double u = box.min().x() + 0.5 * m.spacing; u < box.max().x(); u += m.spacing)
    for (double v = box.min().y() + 0.5 * m.spacing; v < box.max().y(); v += m.spacing)
      if (holds(polygon, {u, v})) at.emplace_back(u, v);
  return at;
}

// Tests whether unit normals with this sum turn so far that their mean says nothing, as those of a tube do.
bool turns_round(const Vec3& sum, std::size_t count) { return !(sum.norm() >= 0.5 * static_cast<double>(count)); }

// Tests whether the surface over the polygon lies between two planes that are `most` [m] apart.
bool is_flat(const ShellModel& m, const PieceSurface& surface, const Polygon& polygon, double most) {
  std::vector<Faces> faces;
  Vec3 normal = Vec3::Zero();
  for (const Vec2& p : places_on(m, polygon)) {
    faces.push_back(surface.at(p));
    if (!faces.back().finite()) return false;
    normal += faces.back().normal;
  }
  if (turns_round(normal, faces.size())) return false;
  normal.normalize();
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Faces& f : faces) {
    const double height = normal.dot(f.middle());
    low = std::min(low, height), high = std::max(high, height);
  }
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const std::size_t j = (i + 1) % polygon.size();
    if (is_torn(surface, (faces[i].low - faces[j].low).norm(), (polygon[i] - polygon[j]).norm(), m.largest_thickness()))
      return false;
  }
  return high - low <= most && (!m.varies() || tapers_evenly(faces, normal, most));
}

// Convex parts that are flat to `most` [m]; no more of them than `enough`, and one, are made.
std::vector<std::vector<Vec3>> flat_parts(const ShellModel& m, const PieceSurface& surface, std::vector<Polygon> open,
                                          double most, std::size_t enough) {
  std::vector<std::vector<Vec3>> parts;
  while (!open.empty() && parts.size() <= enough) {
    const Polygon polygon = std::move(open.back());
    open.pop_back();
    Eigen::AlignedBox2d box;
    for (const Vec2& p : polygon) box.extend(p);
    const bool small = box.sizes().maxCoeff() <= 0.5 * m.spacing;
    if (!small && !is_flat(m, surface, polygon, most)) {
      auto [first, second] = halves_of(polygon, box, bent_along(m, surface, box));
      open.push_back(std::move(first)), open.push_back(std::move(second));
      continue;
    }
    std::vector<Vec3> corners;
    bool whole = true;
    Vec3 twice = Vec3::Zero();
    for (const Vec2& p : polygon) {
      const Faces f = surface.at(p);
      whole = whole && f.finite() &&
              (corners.empty() || !is_torn(surface, (f.low - corners[corners.size() - 2]).norm(), box.diagonal().norm(),
                                           m.largest_thickness()));
      if (corners.size() >= 4) {
        const Vec3 first = 0.5 * (corners[0] + corners[1]), last = 0.5 * (corners.end()[-2] + corners.end()[-1]);
        twice += (last - first).cross(f.middle() - first);
      }
      corners.push_back(f.low), corners.push_back(f.high);
    }
    // no engine takes a part without volume, such as one that a pole of the patch draws to a line
    if (whole && 0.5 * twice.norm() > kLeastPart * m.spacing * m.spacing) parts.push_back(std::move(corners));
  }
  return parts;
}

// Draws a prism for each triangle of a piece. Prisms of one piece share their corners and have no walls between them.
// Returns the parameter [m] of each pair of new points.
std::vector<Vec2> draw_prisms(const PieceSurface& surface, const Triangulation& t, int piece, double thickness,
                              DrawnMesh& drawn) {
  std::vector<Vec2> parameters;
  std::vector<Faces> face(t.vertices.size());
  std::vector<char> known(t.vertices.size(), 0);
  std::vector<int> drawn_as(t.vertices.size(), -1);  // the lower face's point in the mesh
  for (const int i : t.triangles_of(piece)) {
    const auto& c = t.triangles[i];
    bool whole = true;
    for (const int v : c) {
      if (known[v] == 0) known[v] = 1, face[v] = surface.at(t.vertices[v]);
      whole = whole && face[v].finite();
    }
    for (int k = 0; k < 3 && whole; ++k) {
      const int a = c[k], b = c[(k + 1) % 3];
      whole = !is_torn(surface, (face[a].low - face[b].low).norm(), (t.vertices[a] - t.vertices[b]).norm(), thickness);
    }
    if (!whole) continue;
    for (const int v : c) {
      if (drawn_as[v] >= 0) continue;
      drawn_as[v] = static_cast<int>(drawn.points.size());
      drawn.points.push_back(face[v].low), drawn.points.push_back(face[v].high);
      parameters.push_back(t.vertices[v]);
    }
    const auto low = [&](int k) { return drawn_as[c[k]]; };
    drawn.triangles.push_back({low(0) + 1, low(1) + 1, low(2) + 1});
    drawn.triangles.push_back({low(0), low(2), low(1)});
    for (int k = 0; k < 3; ++k) {
      const int other = t.neighbours[i][k], a = low((k + 1) % 3), b = low((k + 2) % 3);
      if (other >= 0 && t.piece[other] == t.piece[i]) continue;
      drawn.triangles.push_back({a, b, b + 1});
      drawn.triangles.push_back({a, b + 1, a + 1});
    }
  }
  return parameters;
}

}  // namespace

double least_thickness_of(const ShellModel& m, const Triangulation& t, int piece) {
  if (!m.varies()) return m.thickness;
  double least = std::numeric_limits<double>::infinity();
  for (const int i : t.triangles_of(piece))
    for (const int v : t.triangles[i]) least = std::min(least, m.thickness_at(t.vertices[v]));
  return std::isfinite(least) ? least : m.least_thickness();
}

bool is_bent(const ShellModel& m, const PieceSurface& surface, const Triangulation& t, int piece, double most) {
  std::vector<char> seen(t.vertices.size(), 0);
  Vec3 normal = Vec3::Zero(), centre = Vec3::Zero();
  std::vector<Vec3> middles;
  std::vector<Faces> faces;  // where the thickness varies
  for (const int i : t.triangles_of(piece))
    for (const int v : t.triangles[i]) {
      if (seen[v]) continue;
      seen[v] = 1;
      const Faces f = surface.at(t.vertices[v]);
      middles.push_back(f.middle());
      if (m.varies()) faces.push_back(f);
      normal += f.normal, centre += middles.back();
    }
  if (middles.empty()) return false;
  if (turns_round(normal, middles.size())) return true;
  normal.normalize(), centre /= static_cast<double>(middles.size());
  if (m.varies() && !tapers_evenly(faces, normal, most)) return true;
  return std::any_of(middles.begin(), middles.end(),
                     [&](const Vec3& x) { return !(std::abs(normal.dot(x - centre)) <= most); });
}

void add_flat_parts(const ShellModel& m, const PieceSurface& surface, const Outline& outline, double most,
                    ConvexShape& shape) {
  const std::vector<Polygon> whole = convex_parts(outline, kPartTolerance * m.spacing * m.spacing);
  const std::size_t enough = std::max(kMostFlatParts, 4 * whole.size());
  std::vector<std::vector<Vec3>> parts = flat_parts(m, surface, whole, most, enough);
  for (int k = 0; k < kDoublings && parts.size() > enough; ++k) {
    most *= 2.0;
    const bool last = k + 1 == kDoublings;
    parts = flat_parts(m, surface, whole, most, last ? std::numeric_limits<std::size_t>::max() : enough);
  }
  std::move(parts.begin(), parts.end(), std::back_inserter(shape.parts));
}

void thicken(const ShellModel& m, const Triangulation& t, int piece, const Vec3& centre, const Mat3& to_body,
             ConvexShape& shape, DrawnMesh& drawn) {
  const PieceSurface rest{[&](const Vec2& p) -> Faces {
                            const SurfacePoint q = m.patch.evaluate(p);
                            const Vec3 unit = q.u.cross(q.v).normalized(), n = 0.5 * m.thickness_at(p) * unit;
                            return {to_body * (q.x - n - centre), to_body * (q.x + n - centre), to_body * unit};
                          },
                          std::numeric_limits<double>::infinity()};
  const Outline outline = outline_of(t, piece);
  // As `rest.at`, but for round-off: bodies of flat panes keep the bits that they have always had.
  const auto faces = [&](const Vec2& p, Vec3& low, Vec3& high) {
    const SurfacePoint q = m.patch.evaluate(p);
    const Vec3 n = 0.5 * m.thickness_at(p) * q.u.cross(q.v).normalized();
    low = to_body * (q.x - n - centre), high = to_body * (q.x + n - centre);
  };
  const std::size_t before = shape.parts.size();
  const double thickness = least_thickness_of(m, t, piece), most = kBentPiece * thickness;
  if (is_bent(m, rest, t, piece, most)) add_flat_parts(m, rest, outline, most, shape);
  if (shape.parts.size() == before)  // flat
    for (const auto& polygon : convex_parts(outline, kPartTolerance * m.spacing * m.spacing)) {
      auto& corners = shape.parts.emplace_back();
      for (const Vec2& p : polygon) {
        corners.emplace_back(), corners.emplace_back();
        faces(p, corners[corners.size() - 2], corners.back());
      }
    }
  if (is_bent(m, rest, t, piece, kDrawnFlat * thickness))
    return add_rest(m, draw_prisms(rest, t, piece, m.largest_thickness(), drawn), drawn);
  const Outline seen = has_inner_cracks(t, piece) ? outline_with_cracks(t, piece) : outline;
  const int first = static_cast<int>(drawn.points.size());
  for (const Vec2& p : seen.vertices) {
    drawn.points.emplace_back(), drawn.points.emplace_back();
    faces(p, drawn.points[drawn.points.size() - 2], drawn.points.back());
  }
  const auto low = [&](int v) { return first + 2 * v; };
  for (const auto& c : seen.triangles) {
    drawn.triangles.push_back({low(c[0]) + 1, low(c[1]) + 1, low(c[2]) + 1});
    drawn.triangles.push_back({low(c[0]), low(c[2]), low(c[1])});
  }
  for (const auto& [a, b] : seen.border) {
    drawn.triangles.push_back({low(a), low(b), low(b) + 1});
    drawn.triangles.push_back({low(a), low(b) + 1, low(a) + 1});
  }
  add_rest(m, seen.vertices, drawn);
}

void add_rest(const ShellModel& m, const std::vector<Vec2>& parameters, DrawnMesh& drawn) {
  if (m.colour) drawn.colour.resize(drawn.rest.size(), Vec3::Ones());
  for (const Vec2& p : parameters) {
    if (m.colour || !drawn.colour.empty()) drawn.colour.insert(drawn.colour.end(), 2, drawn_colour(m, p));
    const SurfacePoint q = m.patch.evaluate(p);
    const Vec3 n = 0.5 * m.thickness_at(p) * q.u.cross(q.v).normalized();
    drawn.rest.push_back(q.x - n), drawn.rest.push_back(q.x + n);
    drawn.uv.insert(drawn.uv.end(), 2, drawn_parameter(m, p));
  }
}

}  // namespace sunder::shell
