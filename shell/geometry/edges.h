#pragma once
// The four edges of a patch, numbered as bits.
#include <vector>

#include "shell/geometry/patch.h"

namespace sunder::shell {

enum EdgeBit { kUMin = 1, kUMax = 2, kVMin = 4, kVMax = 8 };
constexpr int kEdges[] = {kUMin, kUMax, kVMin, kVMax};

/// Lists the control points of an edge in the order of growing v or u; `depth` 0 is the edge itself, 1 the row beside
/// it.
inline std::vector<int> edge_row(const Patch& p, int edge, int depth) {
  std::vector<int> out;
  const int columns = p.columns(), rows = p.rows(), length = edge < kVMin ? rows : columns;
  out.reserve(length);
  for (int k = 0; k < length; ++k)
    out.push_back(edge == kUMin   ? k * columns + depth
                  : edge == kUMax ? k * columns + columns - 1 - depth
                  : edge == kVMin ? depth * columns + k
                                  : (rows - 1 - depth) * columns + k);
  return out;
}

/// Returns the parameter point at share `t` (0 to 1) of an edge, measured along growing v or u.
inline Vec2 edge_point(const Patch& p, int edge, double t) {
  const KnotVector& k = edge < kVMin ? p.knots_v : p.knots_u;
  const double along = t >= 1.0 ? k.end() : k.begin() + t * (k.end() - k.begin());
  if (edge < kVMin) return {edge == kUMin ? p.knots_u.begin() : p.knots_u.end(), along};
  return {along, edge == kVMin ? p.knots_v.begin() : p.knots_v.end()};
}

}  // namespace sunder::shell
