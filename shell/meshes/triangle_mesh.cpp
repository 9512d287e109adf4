#include "shell/meshes/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <queue>

#include <Eigen/Geometry>

#include "coupler/core/error.h"

namespace sunder::shell {
namespace {

constexpr double kNoMeshArea = 1e-10;  // height over the longest side below which a triangle has no area

template <class... Args>
void check(bool good, fmt::format_string<Args...> format, Args&&... args) {
  if (!good) throw Error(Exit::kBadInput, "bad_mesh", fmt::format(format, std::forward<Args>(args)...));
}

std::string at(const Vec3& x) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", x.x(), x.y(), x.z()); }

// The point that each point becomes: the first one within `weld`.
std::vector<int> welded(const std::vector<Vec3>& points, double weld) {
  std::vector<int> out(points.size());
  if (weld <= 0.0) {
    std::map<std::array<double, 3>, int> known;
    for (std::size_t k = 0; k < points.size(); ++k)
      out[k] = known.try_emplace({points[k].x() + 0.0, points[k].y() + 0.0, points[k].z() + 0.0}, static_cast<int>(k))
                   .first->second;
    return out;
  }
  std::map<std::array<std::int64_t, 3>, std::vector<int>> cells;
  for (std::size_t k = 0; k < points.size(); ++k) {
    std::array<std::int64_t, 3> cell{};
    for (int d = 0; d < 3; ++d) cell[d] = static_cast<std::int64_t>(std::floor(points[k][d] / weld));
    out[k] = static_cast<int>(k);
    for (int n = 0; n < 27 && out[k] == static_cast<int>(k); ++n) {
      const auto found = cells.find({cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1});
      if (found == cells.end()) continue;
      for (const int other : found->second)
        if ((points[other] - points[k]).norm() <= weld) {
          out[k] = other;
          break;
        }
    }
    if (out[k] == static_cast<int>(k)) cells[cell].push_back(static_cast<int>(k));
  }
  return out;
}

struct MeshSide {
  int triangle = 0, edge = 0;
};
using MeshEdgeMap = std::map<std::pair<int, int>, std::vector<MeshSide>>;

// Turns triangles so that neighbours agree, and finds components.
void turn_alike(TriangleMesh& m, const MeshEdgeMap& edges, const std::vector<int>& lines, const std::string& word) {
  const auto forward = [&](const MeshSide& s) {
    return m.triangles[s.triangle][s.edge] < m.triangles[s.triangle][(s.edge + 1) % 3];
  };
  std::vector<std::vector<std::pair<int, bool>>> near(m.triangles.size());
  for (const auto& [ends, sides] : edges) {
    if (sides.size() < 2) continue;
    const bool good = forward(sides[0]) != forward(sides[1]);
    near[sides[0].triangle].emplace_back(sides[1].triangle, good);
    near[sides[1].triangle].emplace_back(sides[0].triangle, good);
  }
  m.component.assign(m.triangles.size(), -1);
  std::vector<char> turned(m.triangles.size(), 0);
  for (std::size_t seed = 0; seed < m.triangles.size(); ++seed) {
    if (m.component[seed] >= 0) continue;
    std::vector<int> own{static_cast<int>(seed)};
    m.component[seed] = m.components;
    int flipped = 0;
    for (std::size_t k = 0; k < own.size(); ++k)
      for (const auto& [other, good] : near[own[k]]) {
        const char wanted = good ? turned[own[k]] : !turned[own[k]];
        if (m.component[other] < 0) {
          m.component[other] = m.components, turned[other] = wanted, flipped += wanted, own.push_back(other);
        } else {
          check(turned[other] == wanted,
                "has one side only, as a Moebius strip: no orientation of the face of {} {} fits its neighbours; cut "
                "the surface open there",
                word, lines[other]);
        }
      }
    // The side that most faces have is the one that is meant.
    const bool other_way = 2 * flipped > static_cast<int>(own.size());
    for (const int t : own) {
      turned[t] = (turned[t] != 0) != other_way;
      m.turned += turned[t];
    }
    ++m.components;
  }
  for (std::size_t t = 0; t < m.triangles.size(); ++t)
    if (turned[t])
      std::swap(m.triangles[t][1], m.triangles[t][2]), std::swap(m.corner_of_file[t][1], m.corner_of_file[t][2]);
}

MeshEdgeMap edge_map(const TriangleMesh& m) {
  MeshEdgeMap edges;
  for (std::size_t t = 0; t < m.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      edges[std::minmax(m.triangles[t][k], m.triangles[t][(k + 1) % 3])].push_back({static_cast<int>(t), k});
  return edges;
}

// Gives each further fan of triangles around a point a point of its own: a point bears no load from one to the other.
void part_fans(TriangleMesh& m) {
  std::vector<std::vector<int>> around(m.points.size());
  for (std::size_t t = 0; t < m.triangles.size(); ++t)
    for (const int c : m.triangles[t]) around[c].push_back(static_cast<int>(t));
  std::vector<int> mark(m.triangles.size(), -1);
  for (int c = 0; c < static_cast<int>(around.size()); ++c) {
    int fans = 0;
    for (const int seed : around[c]) {
      if (mark[seed] == c) continue;
      std::vector<int> fan{seed};
      mark[seed] = c;
      for (std::size_t k = 0; k < fan.size(); ++k)
        for (int e = 0; e < 3; ++e) {
          const auto& t = m.triangles[fan[k]];
          const int other = m.beside[fan[k]][e];
          if (other < 0 || mark[other] == c || (t[e] != c && t[(e + 1) % 3] != c)) continue;
          mark[other] = c, fan.push_back(other);
        }
      if (fans++ == 0) continue;
      m.points.push_back(Vec3(m.points[c])), m.of_file.push_back(m.of_file[c]);
      for (const int t : fan)
        std::replace(m.triangles[t].begin(), m.triangles[t].end(), c, static_cast<int>(m.points.size()) - 1);
    }
    if (fans > 1 && m.parted++ == 0) m.first_parted = m.points[c];
  }
}

}  // namespace

TriangleMesh make_triangle_mesh(const std::vector<Vec3>& points, const std::vector<FileTriangle>& triangles,
                                double weld, const std::string& word) {
  check(!triangles.empty(), "has no faces, so there is no surface; export faces as well as points");
  const std::vector<int> same = welded(points, weld);
  TriangleMesh m;
  std::vector<int> number(points.size(), -1), lines;
  std::vector<char> used(points.size(), 0);
  std::map<std::array<int, 3>, int> line_of;  // by sorted corners
  std::vector<std::pair<int, Vec3>> flat;     // line and place of triangles without area
  for (const FileTriangle& t : triangles) {
    std::array<int, 3> own{};
    for (int k = 0; k < 3; ++k) own[k] = same[t.corners[k]], used[t.corners[k]] = 1;
    if (own[0] == own[1] || own[1] == own[2] || own[2] == own[0]) {
      ++m.dropped;
      continue;
    }
    const Vec3 a = points[own[0]], b = points[own[1]], c = points[own[2]];
    const double longest = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    if ((b - a).cross(c - a).norm() <= kNoMeshArea * longest) {
      flat.emplace_back(t.line, a);
      continue;
    }
    std::array<int, 3> sorted = own;
    std::sort(sorted.begin(), sorted.end());
    const auto [known, is_new] = line_of.try_emplace(sorted, t.line);
    check(is_new, "{} {}: the face at {} has the corners of the one of {} {}; leave one of them out", word, t.line,
          at(a), word, known->second);
    for (int k = 0; k < 3; ++k) {
      if (number[own[k]] < 0) {
        number[own[k]] = static_cast<int>(m.points.size());
        m.points.push_back(points[own[k]]), m.of_file.push_back(own[k]);
      }
      own[k] = number[own[k]];
    }
    m.triangles.push_back(own), m.part.push_back(t.part), lines.push_back(t.line);
    const int first = 3 * static_cast<int>(&t - triangles.data());
    m.corner_of_file.push_back({first, first + 1, first + 2});
  }
  check(flat.empty(), "{} {}: the face at {} has no area, the first of {}; leave them out", word,
        flat.empty() ? 0 : flat[0].first, at(flat.empty() ? Vec3() : flat[0].second), flat.size());
  check(!m.triangles.empty(), "has no face with an area: all {} have two corners in one place{}", m.dropped,
        weld > 0.0 ? "; weld less" : "");
  for (std::size_t k = 0; k < points.size(); ++k) m.welded += used[k] && same[k] != static_cast<int>(k);
  MeshEdgeMap edges = edge_map(m);
  const auto crowded = [](const auto& edge) { return edge.second.size() > 2; };
  if (const auto first = std::find_if(edges.begin(), edges.end(), crowded); first != edges.end()) {
    const auto& [ends, sides] = *first;
    check(
        false,
        "has {} edges of three faces or more, the first of {} faces, from {} to {}, the last of them of {} {}; an edge "
        "of a shell belongs to two at most: leave a face out, or make the parts files of their own",
        std::count_if(edges.begin(), edges.end(), crowded), sides.size(), at(m.points[ends.first]),
        at(m.points[ends.second]), word, lines[sides.back().triangle]);
  }
  turn_alike(m, edges, lines, word);
  edges = edge_map(m);
  m.beside.assign(m.triangles.size(), {-1, -1, -1});
  for (const auto& [ends, sides] : edges)
    if (sides.size() == 2) {
      m.beside[sides[0].triangle][sides[0].edge] = sides[1].triangle;
      m.beside[sides[1].triangle][sides[1].edge] = sides[0].triangle;
    }
  part_fans(m);
  return m;
}

std::vector<std::array<char, 3>> creases_of(const TriangleMesh& m, double angle) {
  std::vector<std::array<char, 3>> out(m.triangles.size(), {0, 0, 0});
  for (std::size_t t = 0; t < m.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int other = m.beside[t][k];
      if (other < 0) continue;
      const Vec3 a = m.normal(static_cast<int>(t)), b = m.normal(other);
      out[t][k] = std::atan2(a.cross(b).norm(), a.dot(b)) > angle;
    }
  return out;
}

MeshEdges edges_of(const TriangleMesh& m) {
  MeshEdges out;
  std::map<int, int> next;  // along the border; one fan at each point makes it one
  for (std::size_t t = 0; t < m.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int other = m.beside[t][k];
      out.all += other < 0 || other > static_cast<int>(t);
      if (other < 0) ++out.border, next[m.triangles[t][k]] = m.triangles[t][(k + 1) % 3];
    }
  while (!next.empty()) {
    ++out.loops;
    for (int at_point = next.begin()->first; next.count(at_point) != 0;) {
      const int then = next[at_point];
      next.erase(at_point), at_point = then;
    }
  }
  return out;
}

}  // namespace sunder::shell
