#include "rigid/engine/hulls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "coupler/core/convex_surface.h"
#include "rigid/engine/checks.h"

namespace sunder::rigid {
namespace {

/// Share of a part's diagonal within which points coincide. It is far above the round-off of corners turned into
/// principal axes and back (1e-16), and far below the thickness of thin plates (1e-4).
constexpr double kSame = 1e-9;  // [-]
/// Share of a part's diagonal within which the corners of a face lie in one plane. The division of a mesh leaves 1e-9
/// of the whole mesh's diagonal, which is more of a small part's.
constexpr double kOnePlane = 1e-7;  // [-]
/// Edges whose directions differ by less (sine of the angle) are parallel.
constexpr double kParallel = 1e-6;
/// Limit of corners of a part: contact tries all pairs of edges of two parts.
constexpr std::size_t kMostCorners = 512;

/// Neighbouring triangles of a convex surface that lie in the plane of the largest of them.
struct Flat {
  Vec3 normal;
  std::vector<std::array<int, 3>> triangles;  // corners of the surface
};

std::vector<Flat> flats_of(const Surface& s, double tolerance) {
  const int n = static_cast<int>(s.triangles.size());
  std::map<std::pair<int, int>, int> left_of;  // the triangle of a side
  std::vector<Vec3> across;                    // normals, as long as twice the area
  for (int t = 0; t < n; ++t) {
    const auto& c = s.triangles[t];
    for (int k = 0; k < 3; ++k) left_of[{c[k], c[(k + 1) % 3]}] = t;
    across.push_back((s.corners[c[1]] - s.corners[c[0]]).cross(s.corners[c[2]] - s.corners[c[0]]));
  }
  // A triangle thinner than the tolerance may face anywhere: its normal is round-off.
  const auto faces_away = [&](int t, const Vec3& normal) {
    const auto& c = s.triangles[t];
    double longest = 0.0;
    for (int k = 0; k < 3; ++k) longest = std::max(longest, (s.corners[c[k]] - s.corners[c[(k + 1) % 3]]).norm());
    return normal.dot(across[t]) < 0.0 && across[t].norm() > tolerance * longest;
  };
  std::vector<int> order(n);  // the largest first: normals of slivers are inaccurate
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return across[a].squaredNorm() > across[b].squaredNorm(); });
  std::vector<bool> taken(n, false);
  std::vector<Flat> flats;
  for (const int largest : order) {
    if (taken[largest]) continue;
    Flat flat{across[largest].stableNormalized(), {}};
    const double offset = flat.normal.dot(s.corners[s.triangles[largest][0]]);
    std::vector<int> open{largest};
    taken[largest] = true;
    while (!open.empty()) {
      const auto corners = s.triangles[open.back()];
      open.pop_back();
      flat.triangles.push_back(corners);
      for (int k = 0; k < 3; ++k) {
        const int other = left_of.at({corners[(k + 1) % 3], corners[k]});
        const auto& theirs = s.triangles[other];
        if (taken[other] || faces_away(other, flat.normal) || std::any_of(theirs.begin(), theirs.end(), [&](int c) {
              return std::abs(flat.normal.dot(s.corners[c]) - offset) > tolerance;
            }))
          continue;
        taken[other] = true;
        open.push_back(other);
      }
    }
    flats.push_back(std::move(flat));
  }
  return flats;
}

/// Corners around a flat, anticlockwise from outside. Empty where its outline is more than one loop.
std::vector<int> outline(const Flat& flat) {
  std::map<int, int> next;
  std::set<std::pair<int, int>> sides;
  for (const auto& t : flat.triangles)
    for (int k = 0; k < 3; ++k) sides.insert({t[k], t[(k + 1) % 3]});
  std::size_t count = 0;
  for (const auto& [from, to] : sides)
    if (!sides.contains({to, from})) next[from] = to, ++count;
  if (next.size() != count) return {};  // two loops touch in a corner
  std::vector<int> loop;
  for (int c = next.begin()->first; loop.empty() || c != loop.front(); c = next.at(c)) loop.push_back(c);
  return loop.size() == count ? loop : std::vector<int>{};
}

/// Faces of the convex hull of `hull.points`. In a corner three faces meet: points on edges and in faces are left out.
void find_faces(Hull& hull, const Surface& s, double diagonal) {
  const auto less = [](const Vec3& a, const Vec3& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  };
  std::map<Vec3, int, decltype(less)> place_of(less);
  for (std::size_t i = 0; i < hull.points.size(); ++i) place_of[hull.points[i]] = static_cast<int>(i);
  const std::vector<Flat> flats = flats_of(s, kOnePlane * diagonal);
  std::vector<std::vector<int>> loops;
  std::vector<int> meeting(s.corners.size(), 0);  // faces in each corner
  for (const Flat& f : flats) {
    loops.push_back(outline(f));
    for (const int c : loops.back()) ++meeting[c];
  }
  for (std::size_t f = 0; f < flats.size(); ++f) {
    Hull::Face face;
    face.normal = flats[f].normal;
    for (const int c : loops[f])
      if (meeting[c] >= 3) face.corners.push_back(place_of.at(s.corners[c]));
    if (face.corners.size() < 3) continue;
    const Vec3 x = face.normal.unitOrthogonal(), y = face.normal.cross(x);
    const auto flat = [&](int c) { return std::pair{x.dot(hull.points[c]), y.dot(hull.points[c])}; };
    std::rotate(
        face.corners.begin(),
        std::min_element(face.corners.begin(), face.corners.end(), [&](int a, int b) { return flat(a) < flat(b); }),
        face.corners.end());
    face.offset = face.normal.dot(hull.points[face.corners[0]]);
    for (const int c : face.corners) face.offset = std::max(face.offset, face.normal.dot(hull.points[c]));
    hull.faces.push_back(std::move(face));
  }
  std::sort(hull.faces.begin(), hull.faces.end(), [](const Hull::Face& a, const Hull::Face& b) {
    std::vector<int> i = a.corners, j = b.corners;
    std::sort(i.begin(), i.end()), std::sort(j.begin(), j.end());
    return i < j;
  });
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
  const double diagonal = check_corners(body, part, field);
  if (part.size() > kMostCorners)
    reject_body(
        body, field,
        fmt::format("has {} corners, this engine takes {} at most; take a coarser part", part.size(), kMostCorners));
  Hull hull;
  for (const Vec3& p : part)
    if (std::none_of(hull.points.begin(), hull.points.end(),
                     [&](const Vec3& q) { return (p - q).norm() <= kSame * diagonal; }))
      hull.points.push_back(p);
  const Surface surface = convex_surface(hull.points);
  check_not_flat(body, surface, diagonal, field);
  find_faces(hull, surface, diagonal);
  if (!is_closed(hull))
    reject_body(body, field,
                fmt::format("has {} faces that do not close, over a diagonal of {} m: some of its corners nearly "
                            "coincide; leave such parts out",
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
