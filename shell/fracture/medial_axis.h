#pragma once
// The middle line of a damaged region, from the Voronoi diagram of its boundary (paper section 5.2, figure 6).
#include <array>
#include <functional>
#include <vector>

#include "coupler/core/vec.h"

namespace sunder::shell {

/// A seed of the diagram: a point of the region's boundary.
struct BoundarySample {
  Vec2 p, outward;          // [m]; unit normal out of the region
  bool historical = false;  // beside an earlier crack: lines between such seeds are not new
};

struct MedialAxis {
  std::vector<Vec2> vertices;
  std::vector<std::array<int, 2>> edges;
};

/// Voronoi edges between two new seeds that face one another across the region, and whose ends satisfy `inside`. Fewer
/// than three seeds have none.
MedialAxis medial_axis(const std::vector<BoundarySample>& seeds, const std::function<bool(const Vec2&)>& inside);

/// The axis as polylines between its ends and junctions, each a list of its vertices. Spurs shorter than `spur` [m] are
/// left out.
std::vector<std::vector<int>> polylines(const MedialAxis& axis, double spur);

}  // namespace sunder::shell
