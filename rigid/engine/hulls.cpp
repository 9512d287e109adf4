#include "rigid/engine/hulls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "rigid/engine/checks.h"

namespace sunder::rigid {
namespace {

/// Share of a part's diagonal within which points coincide or lie in one plane. It is far above the round-off of
/// corners turned into principal axes and back (1e-16), and far below the thickness of thin plates (1e-4).
constexpr double kSame = 1e-9;  // [-]
/// Share of (diagonal)^2 below which a triangle is too thin to define a plane.
constexpr double kLeastArea = 1e-11;  // [-]
/// Edges whose directions differ by less (sine of the angle) are parallel.
constexpr double kParallel = 1e-6;
/// Limit of corners of a part: all triples are tried for faces, which takes seconds above it.
constexpr std::size_t kMostCorners = 512;

/// The points `in_plane`, in order around its normal. Points inside edges are left out.
std::vector<int> outline(const std::vector<Vec3>& points, const std::vector<int>& in_plane, const Vec3& normal,
                         double tolerance) {
  const Vec3 x = normal.unitOrthogonal(), y = normal.cross(x);
  std::vector<std::array<double, 2>> flat(points.size());
  for (const int i : in_plane) flat[i] = {x.dot(points[i]), y.dot(points[i])};
  std::vector<int> sorted = in_plane;
  std::sort(sorted.begin(), sorted.end(), [&](int a, int b) { return flat[a] < flat[b]; });
  std::vector<int> chain;
  for (int side = 0; side < 2; ++side) {  // Andrew's monotone chain: below, then above
    const std::size_t base = chain.size();
    for (const int i : sorted) {
      while (chain.size() >= base + 2) {
        const auto &a = flat[chain[chain.size() - 2]], &b = flat[chain.back()], &c = flat[i];
        const double ab_x = b[0] - a[0], ab_y = b[1] - a[1], ac_x = c[0] - a[0], ac_y = c[1] - a[1];
        if (ab_x * ac_y - ab_y * ac_x > tolerance * std::hypot(ac_x, ac_y)) break;
        chain.pop_back();
      }
      chain.push_back(i);
    }
    chain.pop_back();  // the first of the other side
    std::reverse(sorted.begin(), sorted.end());
  }
  return chain;
}

void find_faces(Hull& hull, double diagonal) {
  const auto& p = hull.points;
  const int n = static_cast<int>(p.size());
  const double tolerance = kSame * diagonal;
  std::set<std::vector<int>> known;
  for (int i = 0; i < n; ++i)
    for (int j = i + 1; j < n; ++j)
      for (int k = j + 1; k < n; ++k) {
        Vec3 normal = (p[j] - p[i]).cross(p[k] - p[i]);
        if (normal.norm() < kLeastArea * diagonal * diagonal) continue;
        normal.normalize();
        bool above = false, below = false;
        std::vector<int> in_plane;
        for (int m = 0; m < n && !(above && below); ++m) {
          const double height = normal.dot(p[m] - p[i]);
          if (height > tolerance)
            above = true;
          else if (height < -tolerance)
            below = true;
          else
            in_plane.push_back(m);
        }
        if (above == below || !known.insert(in_plane).second) continue;  // an inner plane, a known face, or a flat part
        if (above) normal = -normal;
        Hull::Face face;
        face.normal = normal;
        face.corners = outline(p, in_plane, normal, tolerance);
        if (face.corners.size() < 3) continue;
        face.offset = normal.dot(p[face.corners[0]]);
        for (const int m : face.corners) face.offset = std::max(face.offset, normal.dot(p[m]));
        hull.faces.push_back(std::move(face));
      }
}

void find_edges(Hull& hull) {
  std::set<std::pair<int, int>> known;
  for (const Hull::Face& face : hull.faces)
    for (std::size_t i = 0; i < face.corners.size(); ++i) {
      const int a = face.corners[i], b = face.corners[(i + 1) % face.corners.size()];
      if (!known.insert({std::min(a, b), std::max(a, b)}).second) continue;
      const Vec3 along = (hull.points[b] - hull.points[a]).normalized();
      std::size_t d = 0;
      while (d < hull.directions.size() && hull.directions[d].cross(along).norm() > kParallel) ++d;
      if (d == hull.directions.size()) hull.directions.push_back(along);
      hull.edges.push_back({a, b, static_cast<int>(d)});
    }
}

/// True where every edge belongs to two faces. Round-off can tear the hull of a bad part.
bool is_closed(const Hull& hull) {
  std::map<std::pair<int, int>, int> uses;
  for (const Hull::Face& face : hull.faces)
    for (std::size_t i = 0; i < face.corners.size(); ++i) {
      const int a = face.corners[i], b = face.corners[(i + 1) % face.corners.size()];
      ++uses[{std::min(a, b), std::max(a, b)}];
    }
  return hull.faces.size() >= 4 && std::all_of(uses.begin(), uses.end(), [](const auto& u) { return u.second == 2; });
}

Hull make_hull(const RigidBody& body, const std::vector<Vec3>& part, const std::string& field) {
  if (part.size() < 4)
    reject_body(body, field, fmt::format("has {} corners, needs at least 4; leave the part out", part.size()));
  if (part.size() > kMostCorners)
    reject_body(
        body, field,
        fmt::format("has {} corners, this engine takes {} at most; take a coarser part", part.size(), kMostCorners));
  Vec3 low = part.front(), high = part.front();
  for (const Vec3& p : part) {
    if (!p.allFinite())
      reject_body(body, field, fmt::format("has a corner ({}, {}, {}) that is not finite", p.x(), p.y(), p.z()));
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double diagonal = (high - low).norm();
  Hull hull;
  for (const Vec3& p : part)
    if (std::none_of(hull.points.begin(), hull.points.end(),
                     [&](const Vec3& q) { return (p - q).norm() <= kSame * diagonal; }))
      hull.points.push_back(p);
  find_faces(hull, diagonal);
  if (!is_closed(hull))
    reject_body(
        body, field,
        fmt::format("has {} faces that do not close, over a diagonal of {} m: it is flat, or some of its corners "
                    "nearly coincide; leave such parts out",
                    hull.faces.size(), diagonal));
  find_edges(hull);
  // Keep corners only. Points inside faces or edges would add contacts without effect.
  std::set<int> used;
  for (const Hull::Edge& e : hull.edges) used.insert({e.from, e.to});
  std::vector<int> place_of(hull.points.size(), -1);
  std::vector<Vec3> corners;
  for (const int i : used) place_of[i] = static_cast<int>(corners.size()), corners.push_back(hull.points[i]);
  hull.points = std::move(corners);
  for (Hull::Face& f : hull.faces)
    for (int& c : f.corners) c = place_of[c];
  for (Hull::Edge& e : hull.edges) e.from = place_of[e.from], e.to = place_of[e.to];
  return hull;
}

}  // namespace

HullShape make_hull_shape(const RigidBody& body) {
  HullShape shape;
  if (const auto* sphere = std::get_if<SphereShape>(&body.shape)) {
    Hull hull;
    hull.radius = sphere->radius;
    hull.points = {Vec3::Zero()};
    shape.parts.push_back(std::move(hull));
  } else if (const auto* box = std::get_if<BoxShape>(&body.shape)) {
    const Vec3& h = box->half_size;
    std::vector<Vec3> corners;
    for (int k = 0; k < 8; ++k) corners.push_back(Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1).cwiseProduct(h));
    shape.parts.push_back(make_hull(body, corners, "shape.half_size"));
  } else if (std::holds_alternative<HalfSpaceShape>(body.shape)) {
    shape.is_half_space = true;
  } else {
    const auto& parts = std::get<ConvexShape>(body.shape).parts;
    for (std::size_t i = 0; i < parts.size(); ++i)
      shape.parts.push_back(make_hull(body, parts[i], fmt::format("shape.parts[{}]", i)));
  }
  for (const Hull& hull : shape.parts)
    for (const Vec3& p : hull.points) shape.reach = std::max(shape.reach, p.norm() + hull.radius);
  return shape;
}

void place(const Hull& local, const BodyMotion& pose, Hull& world) {
  if (world.points.size() != local.points.size()) world = local;
  const Mat3 turn = pose.orientation.toRotationMatrix();
  for (std::size_t i = 0; i < local.points.size(); ++i) world.points[i] = pose.position + turn * local.points[i];
  for (std::size_t i = 0; i < local.directions.size(); ++i) world.directions[i] = turn * local.directions[i];
  for (std::size_t i = 0; i < local.faces.size(); ++i) {
    world.faces[i].normal = turn * local.faces[i].normal;
    world.faces[i].offset = local.faces[i].offset + world.faces[i].normal.dot(pose.position);
  }
}

}  // namespace sunder::rigid
