#include "rigid/engine/touch.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sunder::rigid {
namespace {

constexpr double kFar = std::numeric_limits<double>::max();
/// An axis of two edges is used only where it separates by this much more than the best face. A face gives up to four
/// points, and round-off must not reduce two plates in contact to one point.
constexpr double kFaceAdvantage_m = 1e-5;
/// Two edges at a smaller angle (its sine) do not define a normal.
constexpr double kLeastSine = 1e-3;
/// Two points nearer than this do not define a normal.
constexpr double kNoDistance_m = 1e-9;

struct Range {
  double low = kFar, high = -kFar;
};

Range along(const Hull& hull, const Vec3& axis) {
  Range r;
  for (const Vec3& p : hull.points) {
    const double x = axis.dot(p);
    r.low = std::min(r.low, x);
    r.high = std::max(r.high, x);
  }
  return r;
}

/// A separating axis with its gap [m], negative in an overlap. `normal` points from the first hull to the second.
struct Axis {
  double gap = -kFar;
  Vec3 normal = Vec3::UnitZ();
  int first_face = -1, second_face = -1;            // the face that gives the normal, or
  int first_direction = -1, second_direction = -1;  // the two edge directions
};

/// The axis with the largest gap (separating axis theorem).
Axis best_axis(const Hull& a, const Hull& b, double reach) {
  Axis best;
  for (std::size_t i = 0; i < a.faces.size(); ++i) {
    const double gap = along(b, a.faces[i].normal).low - a.faces[i].offset;
    if (gap > best.gap) best = {gap, a.faces[i].normal, static_cast<int>(i), -1, -1, -1};
  }
  for (std::size_t i = 0; i < b.faces.size(); ++i) {
    const double gap = along(a, b.faces[i].normal).low - b.faces[i].offset;
    if (gap > best.gap) best = {gap, -b.faces[i].normal, -1, static_cast<int>(i), -1, -1};
  }
  if (best.gap > reach) return best;
  const double to_beat = best.gap + kFaceAdvantage_m;
  for (std::size_t i = 0; i < a.directions.size(); ++i)
    for (std::size_t k = 0; k < b.directions.size(); ++k) {
      Vec3 axis = a.directions[i].cross(b.directions[k]);
      const double sine = axis.norm();
      if (sine < kLeastSine) continue;
      axis /= sine;
      const Range of_a = along(a, axis), of_b = along(b, axis);
      const double up = of_b.low - of_a.high, down = of_a.low - of_b.high;
      const double gap = std::max(up, down);
      if (gap > std::max(best.gap, to_beat))
        best = {gap, up >= down ? axis : Vec3(-axis), -1, -1, static_cast<int>(i), static_cast<int>(k)};
    }
  return best;
}

struct Closest {
  Vec3 first = Vec3::Zero(), second = Vec3::Zero();
  double squared = kFar;
};

/// Nearest points of the segments p0 p1 and q0 q1.
Closest closest(const Vec3& p0, const Vec3& p1, const Vec3& q0, const Vec3& q1) {
  const Vec3 u = p1 - p0, v = q1 - q0, w = p0 - q0;
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v), uw = u.dot(w), vw = v.dot(w);
  const double det = uu * vv - uv * uv;
  const auto clamp = [](double x) { return std::min(1.0, std::max(0.0, x)); };
  double s = det > 1e-12 * uu * vv ? clamp((uv * vw - vv * uw) / det) : 0.5;  // parallel: any point serves
  const double t = clamp((vw + s * uv) / vv);
  s = clamp((t * uv - uw) / uu);
  Closest c{p0 + s * u, q0 + t * v, 0.0};
  c.squared = (c.first - c.second).squaredNorm();
  return c;
}

/// True where the edge lies in the plane of the hull's farthest points along the axis.
bool supports(const Hull& hull, const Hull::Edge& e, const Vec3& axis, double highest) {
  return std::min(axis.dot(hull.points[e.from]), axis.dot(hull.points[e.to])) > highest - kFaceAdvantage_m;
}

/// Nearest points of the edges in the supporting planes of the axis; without an axis, of all edges.
Closest closest_edges(const Hull& a, const Hull& b, const Axis* axis) {
  Closest best;
  const double top_a = axis ? along(a, axis->normal).high : 0.0, top_b = axis ? along(b, -axis->normal).high : 0.0;
  for (const Hull::Edge& e : a.edges) {
    if (axis && (e.direction != axis->first_direction || !supports(a, e, axis->normal, top_a))) continue;
    for (const Hull::Edge& f : b.edges) {
      if (axis && (f.direction != axis->second_direction || !supports(b, f, -axis->normal, top_b))) continue;
      const Closest c = closest(a.points[e.from], a.points[e.to], b.points[f.from], b.points[f.to]);
      if (c.squared < best.squared) best = c;
    }
  }
  return best;
}

/// Keeps the part of `polygon` behind the plane.
void clip(std::vector<Vec3>& polygon, const Vec3& normal, double offset) {
  std::vector<Vec3> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double hp = normal.dot(p) - offset, hq = normal.dot(q) - offset;
    if (hp <= 0.0) kept.push_back(p);
    if ((hp < 0.0 && hq > 0.0) || (hp > 0.0 && hq < 0.0)) kept.push_back(p + hp / (hp - hq) * (q - p));
  }
  polygon = std::move(kept);
}

/// Touch points of a face: the opposite face of the other hull, clipped to it. `first` is on the reference hull.
std::vector<Touch> over_face(const Hull& reference, int face_index, const Hull& other, double reach) {
  const Hull::Face& face = reference.faces[face_index];
  const Hull::Face* facing = &other.faces[0];
  for (const Hull::Face& f : other.faces)
    if (f.normal.dot(face.normal) < facing->normal.dot(face.normal)) facing = &f;
  std::vector<Vec3> polygon;
  for (const int c : facing->corners) polygon.push_back(other.points[c]);
  for (std::size_t i = 0; i < face.corners.size() && !polygon.empty(); ++i) {
    const Vec3 &p = reference.points[face.corners[i]],
               &q = reference.points[face.corners[(i + 1) % face.corners.size()]];
    const Vec3 side = (q - p).cross(face.normal).normalized();
    clip(polygon, side, side.dot(p));
  }
  std::vector<Touch> out;
  for (const Vec3& p : polygon) {
    const double gap = face.normal.dot(p) - face.offset;
    if (gap <= reach) out.push_back({p - gap * face.normal, p, -face.normal, gap});
  }
  return out;
}

/// Reduces touch points to four that support as well: the deepest, the farthest from it, and the farthest on both sides
/// of the line between these two.
void keep_four(std::vector<Touch>& all) {
  if (all.size() <= 4) return;
  const auto take = [&](std::size_t place, auto value) {
    std::swap(all[place], *std::max_element(all.begin() + static_cast<std::ptrdiff_t>(place), all.end(),
                                            [&](const Touch& x, const Touch& y) { return value(x) < value(y); }));
  };
  take(0, [](const Touch& t) { return -t.gap; });
  const Vec3 first = all[0].first;
  take(1, [&](const Touch& t) { return (t.first - first).squaredNorm(); });
  const Vec3 across = (all[1].first - first).cross(all[0].normal);
  take(2, [&](const Touch& t) { return across.dot(t.first - first); });
  take(3, [&](const Touch& t) { return -across.dot(t.first - first); });
  all.resize(4);
}

void touch_points(const Vec3& a, double radius_a, const Vec3& b, double radius_b, double reach,
                  std::vector<Touch>& out) {
  const double distance = (a - b).norm();
  const Vec3 normal = distance > kNoDistance_m ? Vec3((a - b) / distance) : Vec3::UnitZ();
  const double gap = distance - radius_a - radius_b;
  if (gap <= reach) out.push_back({a - radius_a * normal, b + radius_b * normal, normal, gap});
}

/// Touch point of a sphere and a polyhedron; `first` is on the sphere.
void touch_point_hull(const Hull& point, const Hull& hull, double reach, std::vector<Touch>& out) {
  const Vec3& p = point.points[0];
  const Hull::Face* highest = nullptr;
  double height = -kFar;
  for (const Hull::Face& f : hull.faces) {
    const double h = f.normal.dot(p) - f.offset;
    if (h > height) height = h, highest = &f;
  }
  if (height > reach + point.radius) return;
  Vec3 foot = p - height * highest->normal;
  bool over = true;
  if (height > 0.0)
    for (std::size_t i = 0; i < highest->corners.size() && over; ++i) {
      const Vec3 &a = hull.points[highest->corners[i]],
                 &b = hull.points[highest->corners[(i + 1) % highest->corners.size()]];
      over = (b - a).cross(highest->normal).dot(foot - a) <= 0.0;
    }
  if (over) {
    out.push_back({p - point.radius * highest->normal, foot, highest->normal, height - point.radius});
    return;
  }
  // Outside, and not over the highest face: the nearest point may be on another face or on an edge.
  double nearest = kFar;
  for (const Hull::Face& f : hull.faces) {
    const double h = f.normal.dot(p) - f.offset;
    if (h <= 0.0) continue;
    const Vec3 on = p - h * f.normal;
    bool inside = true;
    for (std::size_t i = 0; i < f.corners.size() && inside; ++i) {
      const Vec3 &a = hull.points[f.corners[i]], &b = hull.points[f.corners[(i + 1) % f.corners.size()]];
      inside = (b - a).cross(f.normal).dot(on - a) <= 0.0;
    }
    if (inside && h < nearest) nearest = h, foot = on;
  }
  for (const Hull::Edge& e : hull.edges) {
    const Vec3 &a = hull.points[e.from], along_edge = hull.points[e.to] - a;
    const double t = std::min(1.0, std::max(0.0, along_edge.dot(p - a) / along_edge.squaredNorm()));
    const Vec3 on = a + t * along_edge;
    if ((p - on).norm() < nearest) nearest = (p - on).norm(), foot = on;
  }
  touch_points(p, point.radius, foot, 0.0, reach, out);
}

}  // namespace

void touch_half_space(const Hull& part, const Vec3& normal, double offset, double reach, std::vector<Touch>& out) {
  for (const Vec3& p : part.points) {
    const double gap = normal.dot(p) - offset - part.radius;
    const Vec3 on_part = p - part.radius * normal;
    if (gap <= reach) out.push_back({on_part, on_part - gap * normal, normal, gap});
  }
}

void touch_hulls(const Hull& first, const Hull& second, double reach, std::vector<Touch>& out) {
  if (first.is_point() && second.is_point())
    return touch_points(first.points[0], first.radius, second.points[0], second.radius, reach, out);
  if (first.is_point()) return touch_point_hull(first, second, reach, out);
  if (second.is_point()) {
    const std::size_t before = out.size();
    touch_point_hull(second, first, reach, out);
    for (std::size_t i = before; i < out.size(); ++i) {
      std::swap(out[i].first, out[i].second);
      out[i].normal = -out[i].normal;
    }
    return;
  }
  const Axis axis = best_axis(first, second, reach);
  if (axis.gap > reach) return;
  std::vector<Touch> found;
  if (axis.first_face >= 0) {
    found = over_face(first, axis.first_face, second, reach);
  } else if (axis.second_face >= 0) {
    found = over_face(second, axis.second_face, first, reach);
    for (Touch& t : found) {
      std::swap(t.first, t.second);
      t.normal = -t.normal;
    }
  }
  double nearest = kFar;
  for (const Touch& t : found) nearest = std::min(nearest, t.gap);
  if (nearest > axis.gap + kFaceAdvantage_m) {
    // Edge against edge, or faces that are not opposite one another.
    const bool edges = axis.first_direction >= 0;
    const Closest c = closest_edges(first, second, edges && axis.gap <= 0.0 ? &axis : nullptr);
    const double distance = std::sqrt(c.squared);
    if (c.squared == kFar) {
      // round-off: no edge of that direction in the supporting plane; the faces' points serve
    } else if (axis.gap > 0.0 && distance > kNoDistance_m) {
      if (distance <= std::min(reach, nearest - kFaceAdvantage_m))
        out.push_back({c.first, c.second, (c.first - c.second) / distance, distance});
    } else {
      out.push_back({c.first, c.second, -axis.normal, axis.gap});
    }
  }
  keep_four(found);
  out.insert(out.end(), found.begin(), found.end());
}

}  // namespace sunder::rigid
