// Checks that the faces of a file enclose a solid, and turns them outwards.
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <queue>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <Eigen/Dense>
#include <Eigen/Geometry>

#include "coupler/scene/mesh_reader.h"

namespace sunder::scene {
namespace {

constexpr double kTurnedOver = 1e-9;       // share of a face's area: round-off of a corner on a side is below
constexpr double kNoArea = 1e-14;          // share of the square of the diagonal below which a triangle has no area
constexpr std::size_t kMostCorners = 256;  // of a face: ear clipping takes the cube of their number

template <class... Args>
void check(bool good, fmt::format_string<Args...> format, Args&&... args) {
  if (!good) throw Error(Exit::kBadInput, "bad_mesh", fmt::format(format, std::forward<Args>(args)...));
}

std::string place(const Vec3& x) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", x.x(), x.y(), x.z()); }

struct Side {
  int triangle;
  bool forward;  // the triangle runs from the lower corner to the higher
};
using Edges = std::map<std::pair<int, int>, std::vector<Side>>;

Edges edges_of(const Surface& s) {
  Edges edges;
  for (std::size_t t = 0; t < s.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int a = s.triangles[t][k], b = s.triangles[t][(k + 1) % 3];
      edges[std::minmax(a, b)].push_back({static_cast<int>(t), a < b});
    }
  return edges;
}

void check_edges(const Surface& s, const Edges& edges, const std::vector<int>& lines, const std::string& word) {
  int open = 0;
  const Edges::value_type *first = nullptr, *crowded = nullptr;
  for (const auto& edge : edges) {
    if (edge.second.size() == 1 && open++ == 0) first = &edge;
    if (edge.second.size() > 2 && !crowded) crowded = &edge;
  }
  const auto ends = [&](const Edges::value_type& e) {
    return place(s.corners[e.first.first]) + " to " + place(s.corners[e.first.second]);
  };
  if (first)
    check(false,
          "is not closed: {} of its edges belong to one face only, the first of them from {}, of the face of {} {}; "
          "close it, or take surface HULL",
          open, ends(*first), word, lines[first->second[0].triangle]);
  if (crowded)
    check(false, "has an edge of {} faces, from {}, the last of them of {} {}; an edge belongs to two",
          crowded->second.size(), ends(*crowded), word, lines[crowded->second.back().triangle]);
}

// Gives the triangles of each component one orientation. Returns the component of each triangle.
std::vector<int> turn_alike(Surface& s, const Edges& edges, const std::vector<int>& lines, const std::string& word) {
  // Neighbours of each triangle. True: their common edge runs the other way in the neighbour, as it should.
  std::vector<std::vector<std::pair<int, bool>>> beside(s.triangles.size());
  for (const auto& [ends, sides] : edges) {
    const bool good = sides[0].forward != sides[1].forward;
    beside[sides[0].triangle].emplace_back(sides[1].triangle, good);
    beside[sides[1].triangle].emplace_back(sides[0].triangle, good);
  }
  std::vector<int> component(s.triangles.size(), -1);
  std::vector<char> turned(s.triangles.size(), 0);
  int count = 0;
  for (std::size_t seed = 0; seed < s.triangles.size(); ++seed) {
    if (component[seed] >= 0) continue;
    std::queue<int> next({static_cast<int>(seed)});
    component[seed] = count;
    for (; !next.empty(); next.pop())
      for (const auto& [other, good] : beside[next.front()]) {
        const char wanted = good ? turned[next.front()] : !turned[next.front()];
        if (component[other] < 0) {
          component[other] = count, turned[other] = wanted, next.push(other);
        } else {
          check(turned[other] == wanted,
                "has one side only, as a Moebius strip: no orientation of the face of {} {} fits its neighbours; mend "
                "the faces, or take surface HULL",
                word, lines[other]);
        }
      }
    ++count;
  }
  for (std::size_t t = 0; t < s.triangles.size(); ++t)
    if (turned[t]) std::swap(s.triangles[t][1], s.triangles[t][2]);
  return component;
}

// Checks that the triangles around each corner are one fan: the surface does not touch itself there.
void check_corners(const Surface& s, const Edges& edges) {
  std::vector<int> around(s.corners.size(), 0), fans(s.corners.size(), 0);
  for (const auto& t : s.triangles)
    for (const int c : t) ++around[c];
  // Two fans have as many edges as triangles too, so counting finds nothing: walk one fan and compare.
  std::vector<std::map<int, std::vector<int>>> at(s.corners.size());  // corner -> triangle -> triangles beside it there
  for (const auto& [ends, sides] : edges)
    for (const int c : {ends.first, ends.second}) {
      at[c][sides[0].triangle].push_back(sides[1].triangle);
      at[c][sides[1].triangle].push_back(sides[0].triangle);
    }
  for (std::size_t c = 0; c < s.corners.size(); ++c) {
    if (at[c].empty()) continue;
    std::map<int, char> seen;
    std::vector<int> stack{at[c].begin()->first};
    while (!stack.empty()) {
      const int t = stack.back();
      stack.pop_back();
      if (seen[t]++) continue;
      for (const int other : at[c][t]) stack.push_back(other);
    }
    check(static_cast<int>(seen.size()) == around[c],
          "touches itself in the point {}, where {} faces meet that are not one fan; part them there",
          place(s.corners[c]), around[c]);
  }
}

void check_crossings(const Surface& s, const std::vector<int>& lines, const std::string& word) {
  std::map<std::array<int, 3>, int> line_of;  // versions of CGAL differ in whether equal faces cross
  for (std::size_t t = 0; t < s.triangles.size(); ++t) {
    std::array<int, 3> corners = s.triangles[t];
    std::sort(corners.begin(), corners.end());
    const auto [first, fresh] = line_of.emplace(corners, lines[t]);
    check(fresh, "has the same face in {}s {} and {}: nothing lies between them; a body needs a volume", word,
          first->second, lines[t]);
  }
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
  namespace processing = CGAL::Polygon_mesh_processing;
  Mesh mesh;
  for (const Vec3& x : s.corners) mesh.add_vertex({x.x(), x.y(), x.z()});
  for (const auto& [i, j, k] : s.triangles)
    ensure(mesh.add_face(Mesh::Vertex_index(i), Mesh::Vertex_index(j), Mesh::Vertex_index(k)) != Mesh::null_face(),
           "a face of a surface that was found to be closed does not fit");
  std::vector<std::pair<Mesh::Face_index, Mesh::Face_index>> pairs;
  processing::self_intersections(mesh, std::back_inserter(pairs), CGAL::parameters::maximum_number(1));
  if (pairs.empty()) return;
  const auto [a, b] = std::minmax(lines[pairs[0].first.idx()], lines[pairs[0].second.idx()]);
  check(false, "crosses itself: the faces of {}s {} and {} meet near {}; mend it, or take surface HULL", word, a, b,
        place(s.corners[s.triangles[pairs[0].first.idx()][0]]));
}

// Turns each component outwards, and inwards where it lies inside an odd number of others: then it is a hollow.
void turn_outwards(Surface& s, const std::vector<int>& component) {
  const int count = 1 + *std::max_element(component.begin(), component.end());
  std::vector<Surface> parts(count, Surface{s.corners, {}});
  for (std::size_t t = 0; t < s.triangles.size(); ++t) parts[component[t]].triangles.push_back(s.triangles[t]);
  std::vector<char> turned(count, 0);
  for (int c = 0; c < count; ++c) {
    int depth = 0;
    for (int other = 0; other < count; ++other)
      if (other != c) depth += std::abs(winding_number(parts[other], s.corners[parts[c].triangles[0][0]])) > 0.5;
    turned[c] = (enclosed_volume(parts[c]) < 0.0) != (depth % 2 == 1);
  }
  for (std::size_t t = 0; t < s.triangles.size(); ++t)
    if (turned[component[t]]) std::swap(s.triangles[t][1], s.triangles[t][2]);
}

}  // namespace

std::vector<std::array<int, 3>> triangulated(const std::vector<Vec3>& points, const Polygon& polygon,
                                             const std::string& word) {
  const auto count = polygon.corners.size();
  check(count >= 3 && count <= kMostCorners, "{} {}: a face has {} corners; 3 to {}", word, polygon.line, count,
        kMostCorners);
  for (const int c : polygon.corners)
    check(c >= 0 && c < static_cast<int>(points.size()), "{} {}: the face names point {}, and there are {}", word,
          polygon.line, c, points.size());
  std::vector<int> left = polygon.corners;
  Vec3 normal = Vec3::Zero();
  for (std::size_t i = 0; i < left.size(); ++i)
    normal += (points[left[i]] - points[left[0]]).cross(points[left[(i + 1) % left.size()]] - points[left[0]]);
  std::vector<std::array<int, 3>> out;
  const auto side = [&](int a, int b, int c) {
    return normal.dot((points[b] - points[a]).cross(points[c] - points[a]));
  };
  const auto check_clear = [&](bool clear) {
    check(clear, "{} {}: the face of {} corners crosses or touches itself; divide it into triangles", word,
          polygon.line, count);
  };
  while (left.size() > 3) {
    const std::size_t n = left.size();
    std::size_t best = n;
    double roundest = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const int a = left[(i + n - 1) % n], b = left[i], c = left[(i + 1) % n];
      const double area = side(a, b, c);
      if (area <= 0.0) continue;
      const bool clear = std::none_of(left.begin(), left.end(), [&](int p) {
        return p != a && p != b && p != c && side(a, b, p) >= 0.0 && side(b, c, p) >= 0.0 && side(c, a, p) >= 0.0;
      });
      const double longest = std::max({(points[b] - points[a]).squaredNorm(), (points[c] - points[b]).squaredNorm(),
                                       (points[a] - points[c]).squaredNorm()});
      if (clear && area / longest > roundest) best = i, roundest = area / longest;
    }
    check_clear(best < n);
    out.push_back({left[(best + n - 1) % n], left[best], left[(best + 1) % n]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(best));
  }
  // What crosses itself may leave a triangle that is turned over.
  check_clear(side(left[0], left[1], left[2]) >= -kTurnedOver * normal.squaredNorm());
  out.push_back({left[0], left[1], left[2]});
  return out;
}

Surface closed_surface(const std::vector<Vec3>& points, const std::vector<Polygon>& polygons, const std::string& word) {
  Surface s;
  std::vector<int> lines, corner_of;
  std::map<std::array<double, 3>, int> known;  // files with colours or normals repeat points
  Eigen::AlignedBox3d box;
  for (const Vec3& x : points) {
    const auto [at, is_new] =
        known.try_emplace({x.x() + 0.0, x.y() + 0.0, x.z() + 0.0}, static_cast<int>(s.corners.size()));
    if (is_new) s.corners.push_back(x);
    corner_of.push_back(at->second), box.extend(x);
  }
  check(!polygons.empty(),
        "has points and no faces, so that nothing says what it encloses; give faces, or take "
        "surface HULL");
  for (const Polygon& polygon : polygons) {
    Polygon mine{{}, polygon.line};
    for (const int c : polygon.corners) {
      check(c >= 0 && c < static_cast<int>(points.size()), "{} {}: the face names point {}, and there are {}", word,
            polygon.line, c, points.size());
      mine.corners.push_back(corner_of[c]);
    }
    for (const auto& t : triangulated(s.corners, mine, word)) {
      const double area = 0.5 * (s.corners[t[1]] - s.corners[t[0]]).cross(s.corners[t[2]] - s.corners[t[0]]).norm();
      check(area > kNoArea * box.diagonal().squaredNorm(), "{} {}: the face at {} has no area; leave it out", word,
            polygon.line, place(s.corners[t[0]]));
      s.triangles.push_back(t), lines.push_back(polygon.line);
    }
    check(static_cast<int>(s.triangles.size()) <= kMostTriangles,
          "has more than {} triangles; {}, or take surface HULL", kMostTriangles, kReduce);
  }
  std::vector<int> used(s.corners.size(), -1);  // points without a face are left out
  std::vector<Vec3> corners;
  for (auto& t : s.triangles)
    for (int& c : t) {
      if (used[c] < 0) used[c] = static_cast<int>(corners.size()), corners.push_back(s.corners[c]);
      c = used[c];
    }
  s.corners = std::move(corners);
  const Edges edges = edges_of(s);
  check_edges(s, edges, lines, word);
  const std::vector<int> component = turn_alike(s, edges, lines, word);
  check_corners(s, edges);
  check_crossings(s, lines, word);
  turn_outwards(s, component);
  const double volume = enclosed_volume(s);
  check(volume > kLeastVolume * std::pow(box.diagonal().norm(), 3), "encloses {:.3g} m^3; a body needs a volume",
        volume);
  return s;
}

}  // namespace sunder::scene
