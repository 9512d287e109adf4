#include "shell/io/cad_sides.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <utility>

namespace sunder::shell {
namespace {

// Of the length of an edge. Loose faces have gaps; a wrong match could only turn a face over.
constexpr double kAlikeEnds = 1e-3, kAlikeMiddles = 0.1;

// A face beside another one; `turned` where their normals look to opposite sides.
struct Beside {
  int face = 0;
  bool turned = false;
};

// An edge of one face.
struct Free {
  const CadEdge* edge = nullptr;
  int face = 0, sense = 0;
};

// 1 where two edges run together, -1 where they do so in opposite directions, 0 where they do not.
int run_together(const CadEdge& a, const CadEdge& b) {
  const double near = kAlikeEnds * a.length;
  if (std::abs(a.length - b.length) > near || (a.middle - b.middle).norm() > kAlikeMiddles * a.length) return 0;
  const auto meet = [&](const Vec3& x, const Vec3& y) { return (x - y).norm() <= near; };
  if (meet(a.points.front(), b.points.front()) && meet(a.points.back(), b.points.back()))
    return meet(a.points.front(), a.points.back()) ? 0 : 1;  // closed ones do not tell
  return meet(a.points.front(), b.points.back()) && meet(a.points.back(), b.points.front()) ? -1 : 0;
}

}  // namespace

std::vector<int> faces_to_turn(const std::vector<CadEdge>& edges, const std::vector<int>& faces) {
  std::map<int, std::vector<Beside>> beside;
  for (const int face : faces) beside[face];
  // The borders of two faces that look to one side run along their edge in opposite directions.
  const auto join = [&](int a, int b, int same_direction) {
    beside[a].push_back({b, same_direction > 0}), beside[b].push_back({a, same_direction > 0});
  };
  std::vector<Free> free;
  for (const CadEdge& edge : edges) {
    std::vector<Free> own;
    for (std::size_t k = 0; k < edge.faces.size(); ++k)
      if (beside.count(edge.faces[k]) != 0 && edge.senses[k] != 0)
        own.push_back({&edge, edge.faces[k], edge.senses[k]});
    if (own.size() == 2) join(own[0].face, own[1].face, own[0].sense * own[1].sense);
    if (own.size() == 1) free.push_back(own[0]);
  }
  std::stable_sort(free.begin(), free.end(),
                   [](const Free& a, const Free& b) { return a.edge->length < b.edge->length; });
  for (std::size_t a = 0; a < free.size(); ++a)
    for (std::size_t b = a + 1;
         b < free.size() && free[b].edge->length <= (1.0 + 2.0 * kAlikeEnds) * free[a].edge->length; ++b)
      if (const int same = run_together(*free[a].edge, *free[b].edge); same != 0 && free[a].face != free[b].face)
        join(free[a].face, free[b].face, same * free[a].sense * free[b].sense);
  std::vector<int> out;
  std::map<int, bool> turned;  // against the first face of those that are connected
  for (const auto& [first, unused] : beside) {
    if (turned.count(first) != 0) continue;
    std::vector<int> sides[2];
    bool two_sided = true;
    std::queue<int> next({first});
    turned[first] = false;
    while (!next.empty()) {
      const int face = next.front();
      next.pop(), sides[turned[face]].push_back(face);
      for (const Beside& b : beside[face]) {
        const bool wanted = turned[face] != b.turned;
        const auto [at, is_new] = turned.try_emplace(b.face, wanted);
        if (is_new) next.push(b.face);
        two_sided = two_sided && at->second == wanted;
      }
    }
    const std::vector<int>& fewer = sides[1].size() <= sides[0].size() ? sides[1] : sides[0];
    if (two_sided) out.insert(out.end(), fewer.begin(), fewer.end());
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace sunder::shell
