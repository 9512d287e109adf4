// Divides a solid into convex parts: a binary partition of space by the planes of its faces.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <set>

#include <Eigen/Dense>
#include <Eigen/Geometry>

#include "coupler/scene/mesh.h"

namespace sunder::scene {
namespace {

constexpr double kThin = 1e-9;     // share of the diagonal: points nearer to a plane lie in it
constexpr double kNothing = 1e-9;  // share of the solid's volume: less is round-off
constexpr std::size_t kMostCells = 4000, kMostCandidates = 64;
constexpr double kWhole = 1e-6;  // share of the volume by which the sum of all cells may differ
/// Share of a part's diagonal below which it is a sliver: two planes of the mesh are nearly one. Engines compute hulls
/// on grids of 1e-4 of their size. A sliver is left out where it has less than kWhole of the volume.
constexpr double kSliver = 1e-3;

struct Plane {
  Vec3 normal;
  double offset;  // normal . x in the plane
  double height(const Vec3& x) const { return normal.dot(x) - offset; }
};
using Loop = std::vector<Vec3>;  // corners of a flat, convex polygon
struct Face {                    // the piece of a surface triangle inside a cell
  Loop loop;
  int plane;
};
struct Cell {
  std::vector<Loop> sides;
  std::vector<Face> faces;
};
struct Halves {
  Loop front, back;
};

// The two parts of a convex loop in front of a plane and behind it. A loop that only touches the plane is on its own
// side only. A loop in the plane is on neither side.
Halves cut(const Loop& loop, const Plane& plane, double thin) {
  Halves out;
  double low = 0.0, high = 0.0;
  std::vector<double> height;
  for (const Vec3& x : loop) {
    height.push_back(plane.height(x));
    low = std::min(low, height.back()), high = std::max(high, height.back());
  }
  if (low >= -thin && high <= thin) return out;
  if (low >= -thin) return {loop, {}};
  if (high <= thin) return {{}, loop};
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const std::size_t j = (i + 1) % loop.size();
    if (height[i] >= -thin) out.front.push_back(loop[i]);
    if (height[i] <= thin) out.back.push_back(loop[i]);
    if ((height[i] > thin && height[j] < -thin) || (height[i] < -thin && height[j] > thin)) {
      const Vec3 x = loop[i] + height[i] / (height[i] - height[j]) * (loop[j] - loop[i]);
      out.front.push_back(x), out.back.push_back(x);
    }
  }
  return out;
}

// The polygon in which a plane cuts a convex cell, from the corners of the cell's sides in that plane.
Loop cap(const std::vector<Loop>& sides, const Plane& plane, double thin) {
  Loop points;
  for (const Loop& side : sides)
    for (const Vec3& x : side)
      if (std::abs(plane.height(x)) <= thin &&
          std::none_of(points.begin(), points.end(), [&](const Vec3& p) { return (p - x).norm() <= 4.0 * thin; }))
        points.push_back(x);
  if (points.size() < 3) return {};
  Vec3 middle = Vec3::Zero();
  for (const Vec3& x : points) middle += x / static_cast<double>(points.size());
  const Vec3 u = plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
  const auto angle = [&](const Vec3& x) { return std::atan2(v.dot(x - middle), u.dot(x - middle)); };
  std::sort(points.begin(), points.end(), [&](const Vec3& a, const Vec3& b) { return angle(a) < angle(b); });
  return points;
}

std::vector<Plane> planes_of(const Surface& s, double thin, std::vector<int>& of_triangle) {
  std::vector<Plane> planes;
  std::vector<std::pair<double, std::size_t>> order;  // the largest first: normals of slivers are inaccurate
  const auto across = [&](std::size_t t) -> Vec3 {
    const auto& [i, j, k] = s.triangles[t];
    return (s.corners[j] - s.corners[i]).cross(s.corners[k] - s.corners[i]);
  };
  for (std::size_t t = 0; t < s.triangles.size(); ++t) order.emplace_back(-across(t).norm(), t);
  std::sort(order.begin(), order.end());
  of_triangle.resize(s.triangles.size());
  for (const auto& [unused, t] : order) {
    const Vec3 normal = across(t).normalized();
    const auto same = [&, &corners = s.triangles[t]](const Plane& p) {
      return p.normal.dot(normal) > 0.0 && std::all_of(corners.begin(), corners.end(),
                                                       [&](int c) { return std::abs(p.height(s.corners[c])) <= thin; });
    };
    const auto found = std::find_if(planes.begin(), planes.end(), same);
    of_triangle[t] = static_cast<int>(found - planes.begin());
    if (found == planes.end()) planes.push_back({normal, normal.dot(s.corners[s.triangles[t][0]])});
  }
  return planes;
}

struct Reach {
  double low = 0.0, high = 0.0;  // of a loop below and above a plane [m]
};
Reach reach(const Loop& loop, const Plane& plane) {
  Reach r;
  for (const Vec3& x : loop) {
    const double h = plane.height(x);
    r.low = std::min(r.low, h), r.high = std::max(r.high, h);
  }
  return r;
}

// Chooses the plane that cuts a cell. Best is a plane with no face in front of it: it cuts no part. Otherwise, of at
// most kMostCandidates planes, the one that cuts fewest faces and leaves similar numbers on both sides.
int choose(const Cell& cell, const std::vector<Plane>& planes, double thin) {
  std::vector<int> asked;
  for (const Face& f : cell.faces) asked.push_back(f.plane);
  std::sort(asked.begin(), asked.end());
  asked.erase(std::unique(asked.begin(), asked.end()), asked.end());
  for (const int candidate : asked)
    if (std::all_of(cell.faces.begin(), cell.faces.end(),
                    [&](const Face& f) { return reach(f.loop, planes[candidate]).high <= thin; }))
      return candidate;
  int best = asked[0];
  long best_score = -1;
  const std::size_t stride = 1 + asked.size() / kMostCandidates;
  for (std::size_t k = 0; k < asked.size(); k += stride) {
    long front = 0, back = 0, crossing = 0;
    for (const Face& f : cell.faces) {
      const Reach r = reach(f.loop, planes[asked[k]]);
      const bool above = r.high > thin, below = r.low < -thin;
      crossing += above && below, front += above && !below, back += below && !above;
    }
    const long score = 8 * crossing + std::abs(front - back);
    if (best_score < 0 || score < best_score) best = asked[k], best_score = score;
  }
  return best;
}

Cell box_around(const Eigen::AlignedBox3d& box) {
  Cell cell;
  for (int d = 0; d < 3; ++d)
    for (const double end : {-0.6, 0.6}) {
      Loop loop;
      for (const auto& [p, q] :
           {std::pair{-0.6, -0.6}, std::pair{0.6, -0.6}, std::pair{0.6, 0.6}, std::pair{-0.6, 0.6}}) {
        Vec3 x;
        x[d] = end, x[(d + 1) % 3] = p, x[(d + 2) % 3] = q;
        loop.push_back(box.center() + x * box.diagonal().norm());
      }
      cell.sides.push_back(loop);
    }
  return cell;
}

std::vector<Hull> cells_inside(const Surface& s, double volume) {
  Eigen::AlignedBox3d box;
  for (const Vec3& x : s.corners) box.extend(x);
  const double thin = kThin * box.diagonal().norm();
  std::vector<int> plane_of;
  const std::vector<Plane> planes = planes_of(s, thin, plane_of);
  std::vector<Cell> open{box_around(box)};
  for (std::size_t t = 0; t < s.triangles.size(); ++t) {
    Loop loop;
    for (const int c : s.triangles[t]) loop.push_back(s.corners[c]);
    open[0].faces.push_back({loop, plane_of[t]});
  }
  std::vector<Hull> inside;
  std::size_t cells = 0;
  while (!open.empty()) {
    const Cell cell = std::move(open.back());
    open.pop_back();
    if (cell.faces.empty()) {
      std::vector<Vec3> points;
      for (const Loop& side : cell.sides) points.insert(points.end(), side.begin(), side.end());
      Vec3 middle = Vec3::Zero();
      for (const Vec3& x : points) middle += x / static_cast<double>(points.size());
      if (winding_number(s, middle) < 0.5) continue;
      Hull part = hull_of(points);
      if (part.volume > kNothing * kNothing * volume) inside.push_back(std::move(part));
      continue;
    }
    if (++cells > kMostCells)
      throw Error(
          Exit::kBadInput, "bad_mesh",
          fmt::format("would be cut into more than {} cells on the way to convex parts; simplify it", kMostCells));
    const int chosen = choose(cell, planes, thin);
    Cell front, back;
    for (const Loop& side : cell.sides) {
      Halves h = cut(side, planes[chosen], thin);
      if (h.front.size() > 2) front.sides.push_back(std::move(h.front));
      if (h.back.size() > 2) back.sides.push_back(std::move(h.back));
    }
    for (const Face& f : cell.faces) {
      if (f.plane == chosen) continue;
      Halves h = cut(f.loop, planes[chosen], thin);
      if (h.front.size() > 2) front.faces.push_back({std::move(h.front), f.plane});
      if (h.back.size() > 2) back.faces.push_back({std::move(h.back), f.plane});
    }
    for (Cell* half : {&front, &back}) {
      if (half->sides.empty()) continue;  // the plane touches the cell only
      if (const Loop lid = cap(half->sides, planes[chosen], thin); !lid.empty()) half->sides.push_back(lid);
      if (half->sides.size() >= 4) open.push_back(std::move(*half));
    }
  }
  return inside;
}

struct Pair {
  std::size_t first, second;
  Hull both;
  double added;  // by the hull of both [m^3]
};

// Hull of two parts that touch; nothing where they do not, or where it would have too many corners.
std::optional<Pair> try_pair(const std::vector<Hull>& parts, std::size_t i, std::size_t j, double thin) {
  Eigen::AlignedBox3d a, b;
  for (const Vec3& x : parts[i].corners) a.extend(x);
  for (const Vec3& x : parts[j].corners) b.extend(x);
  if (a.squaredExteriorDistance(b) > thin * thin) return {};
  std::vector<Vec3> points = parts[i].corners;
  points.insert(points.end(), parts[j].corners.begin(), parts[j].corners.end());
  Hull both = hull_of(points);
  if (static_cast<int>(both.corners.size()) > kMostHullCorners) return {};
  const double added = both.volume - parts[i].volume - parts[j].volume;
  return Pair{i, j, std::move(both), added};
}

bool is_sliver(const Hull& part) {
  const Surface s = convex_surface(part.corners);
  Eigen::AlignedBox3d box;
  for (const Vec3& x : s.corners) box.extend(x);
  double width = std::numeric_limits<double>::infinity();  // least distance of a face from the corner farthest from it
  for (const auto& [i, j, k] : s.triangles) {
    const Vec3 normal = (s.corners[j] - s.corners[i]).cross(s.corners[k] - s.corners[i]).stableNormalized();
    double depth = 0.0;
    for (const Vec3& x : s.corners) depth = std::max(depth, normal.dot(s.corners[i] - x));
    width = std::min(width, depth);
  }
  return width < kSliver * box.diagonal().norm();
}

}  // namespace

double winding_number(const Surface& s, const Vec3& point) {
  double angle = 0.0;  // half of the solid angle of each triangle, Van Oosterom and Strackee 1983
  for (const auto& [i, j, k] : s.triangles) {
    const Vec3 a = s.corners[i] - point, b = s.corners[j] - point, c = s.corners[k] - point;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle / (2.0 * std::numbers::pi);
}

Hull hull_of(const std::vector<Vec3>& points) {
  const Surface s = convex_surface(points);
  if (s.triangles.size() < 4) return {};
  // In a corner three planes meet. Points that round-off leaves on edges and faces are no corners.
  std::vector<int> plane_of;
  Eigen::AlignedBox3d box;
  for (const Vec3& p : points) box.extend(p);
  planes_of(s, kThin * box.diagonal().norm(), plane_of);
  std::vector<std::set<int>> planes(s.corners.size());
  for (std::size_t t = 0; t < s.triangles.size(); ++t)
    for (const int c : s.triangles[t]) planes[c].insert(plane_of[t]);
  Hull hull;
  hull.volume = enclosed_volume(s);
  for (std::size_t c = 0; c < s.corners.size(); ++c)
    if (planes[c].size() >= 3) hull.corners.push_back(s.corners[c]);
  return hull;
}

std::vector<std::vector<Vec3>> convex_parts(const Surface& surface) {
  const auto refuse = [](const std::string& what) { throw Error(Exit::kBadInput, "bad_mesh", what); };
  const double volume = enclosed_volume(surface);
  Eigen::AlignedBox3d box;
  for (const Vec3& x : surface.corners) box.extend(x);
  std::vector<Hull> parts = cells_inside(surface, volume);
  double sum = 0.0;
  for (const Hull& p : parts) sum += p.volume;
  if (std::abs(sum - volume) > kWhole * volume)
    refuse(
        fmt::format("its convex parts have {:.9g} m^3, and it has {:.9g} m^3: faces nearly touch or are nearly in "
                    "one plane; simplify it",
                    sum, volume));
  // Merge pairs whose hull adds nothing first. While parts are too many, merge the pair whose hull adds least.
  std::vector<Pair> pairs;
  const auto ask = [&](std::size_t i, std::size_t j) {
    if (parts[i].corners.empty() || parts[j].corners.empty()) return;
    if (auto pair = try_pair(parts, i, j, kThin * box.diagonal().norm())) pairs.push_back(std::move(*pair));
  };
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) ask(j, i);
  std::size_t left = parts.size();
  double added = 0.0;
  while (!pairs.empty()) {
    const auto best =
        std::min_element(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.added < b.added; });
    const bool nothing = best->added <= kNothing * volume;
    if (!nothing && (left <= static_cast<std::size_t>(kMostParts) || added + best->added > kMostAdded * volume)) break;
    if (!nothing) added += best->added;
    const std::size_t i = best->first, j = best->second;
    parts[i] = std::move(best->both), parts[j] = {};
    --left;
    std::erase_if(pairs, [&](const Pair& p) { return p.first == i || p.second == i || p.first == j || p.second == j; });
    for (std::size_t k = 0; k < parts.size(); ++k)
      if (k != i) ask(std::min(i, k), std::max(i, k));
  }
  std::vector<std::vector<Vec3>> out;
  for (const Hull& p : parts) {
    if (p.volume <= kNothing * volume || (p.volume <= kWhole * volume && is_sliver(p))) continue;
    const bool many = static_cast<int>(p.corners.size()) > kMostHullCorners;
    out.push_back(many ? simplified_hull(convex_surface(p.corners)).corners : p.corners);
  }
  if (static_cast<int>(out.size()) > kMostParts)
    refuse(fmt::format("is made of {} convex parts, at most {} can be used; simplify it, or take surface HULL",
                       out.size(), kMostParts));
  return out;
}

}  // namespace sunder::scene
