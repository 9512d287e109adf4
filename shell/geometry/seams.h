#pragma once
// Where patches meet along whole edges, and what that means for their control points.
#include <functional>
#include <string>
#include <vector>

#include "shell/geometry/edges.h"

namespace sunder::shell {

/// How two patches hang together where they meet.
enum class Join {
  kClamped,  // as one surface: slopes go on where the seam is smooth, and it keeps its angle where it is a crease
  kHinge,    // positions only
  kOpen,     // not at all
};

struct PatchPoint {
  int patch = 0, point = 0;  // control point
  friend bool operator==(const PatchPoint&, const PatchPoint&) = default;
  friend auto operator<=>(const PatchPoint&, const PatchPoint&) = default;
};

/// A control point that moves with others: its position is their weighted mean (weights sum to 1).
struct Dependence {
  PatchPoint point;
  std::vector<std::pair<PatchPoint, double>> on;
};

/// Control points on both sides of a crease: those next to it, whose distance tells its angle.
struct CreasePoint {
  PatchPoint first;
  std::vector<std::pair<PatchPoint, double>> second;  // weighted mean of control points
  PatchPoint on_seam;
  double width = 0.0;  // of the seam that belongs to it [m]
};

struct Seam {
  int first = 0, second = 0;            // patches; `second` follows `first`, which is not finer along the edge
  int first_edge = 0, second_edge = 0;  // EdgeBit
  bool reversed = false;                // the edges run against one another
  bool smooth = false;
  Join join = Join::kClamped;
  double length = 0.0;              // [m]
  double angle = 0.0;               // largest between the surfaces, 0 where they go on straight [rad]
  std::vector<CreasePoint> crease;  // of a clamped one
};

struct Stitches {
  std::vector<Seam> seams;
  std::vector<Dependence> points;  // what they depend on depends on nothing itself
};

/// Finds edges that meet within `tolerance` [m] and ties their control points by virtual uncommon knot insertion (Coox
/// et al. 2017): on the edge those of the finer side follow the coarser, exactly where they have all its knots and
/// by local interpolation elsewhere. Where the seam is smooth its row is the mean of the rows beside it instead.
/// `join[i][k]` says how patches i and k hang together. What is `held` anyway follows nothing; at an end of a seam,
/// what meets it follows it. Throws Error where edges nearly meet, meet over a part of their length, or where the
/// normals of a smooth seam are opposite.
Stitches find_stitches(const std::vector<const Patch*>& patches, const std::vector<std::string>& names,
                       double tolerance, const std::vector<std::vector<Join>>& join,
                       const std::function<bool(const PatchPoint&)>& held = {});

}  // namespace sunder::shell
