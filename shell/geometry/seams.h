#pragma once
// Finds where patches meet along whole edges, and which control points depend on others there.
#include <functional>
#include <string>
#include <vector>

#include "shell/geometry/edges.h"

namespace sunder::shell {

/// How two patches are joined where they meet.
enum class Join {
  kClamped,  // positions and slopes: a smooth seam stays smooth, a crease keeps its angle
  kHinge,    // positions only
  kOpen,     // not joined
};

/// A control point, named by its patch and its index there.
struct PatchPoint {
  int patch = 0, point = 0;  // control point
  friend bool operator==(const PatchPoint&, const PatchPoint&) = default;
  friend auto operator<=>(const PatchPoint&, const PatchPoint&) = default;
};

/// A dependent control point. Its position is the weighted mean of independent control points; the weights sum to 1.
struct Dependence {
  PatchPoint point;
  std::vector<std::pair<PatchPoint, double>> on;
};

/// Control points on both sides of a crease, one row away from it. Their distance measures the angle of the crease.
struct CreasePoint {
  PatchPoint first;
  std::vector<std::pair<PatchPoint, double>> second;  // weighted mean of control points
  PatchPoint on_seam;
  double width = 0.0;  // length of seam that this point stands for [m]
};

/// A place at which two borders run together, where one of both patches is trimmed.
struct SeamPlace {
  Vec2 first = Vec2::Zero(), second = Vec2::Zero();  // parameters in both patches
  // Parameter directions into both patches, across the seam; one unit is a metre of the surface.
  Vec2 into_first = Vec2::Zero(), into_second = Vec2::Zero();
  double along = 0.0;   // from the beginning of the seam [m]
  double length = 0.0;  // of seam that it stands for [m]
};

/// Two edges that meet over their whole length, or two borders that run together along a trim loop.
struct Seam {
  int first = 0, second = 0;            // patches; `second` depends on `first`, which is not finer along the edge
  int first_edge = 0, second_edge = 0;  // EdgeBit
  bool reversed = false;                // the two edges run in opposite directions
  bool smooth = false;
  Join join = Join::kClamped;
  double length = 0.0;              // [m]
  double angle = 0.0;               // largest angle between the surfaces, 0 for a smooth seam [rad]
  std::vector<CreasePoint> crease;  // of a clamped crease
  std::vector<SeamPlace> places{};  // along a trim loop; empty: both are whole edges
  bool closed = false;              // the places go round, and the last one is beside the first
  double strength = 0.0;            // force per length at which it opens [N/m]; 0: it does not

  bool trimmed() const { return !places.empty(); }
};

/// All seams of a scene and the control points that depend on others because of them.
struct Stitches {
  std::vector<Seam> seams;
  std::vector<Dependence> points;  // no point depends on another dependent point
};

/// Finds edges that meet within `tolerance` [m] and makes control points of one side depend on the other (virtual
/// uncommon knot insertion, Coox et al. 2017). On the edge, control points of the finer side depend on the coarser
/// side. The dependence is exact where the finer side has all knots of the coarser one; elsewhere it is a local
/// interpolation. On a smooth seam the edge row is the mean of the rows on both sides. `join[i][k]` says how patches i
/// and k are joined. `held` is true for a control point that a support holds: it depends on no other. Where such a
/// point ends a seam, the point that it meets depends on it. Throws Error where edges nearly meet, meet over a part of
/// their length, differ in degree, do not fit, or where the normals at a smooth seam are opposite. `whole[i]`: EdgeBits
/// of the edges of patch i that exist; empty: all.
Stitches find_stitches(const std::vector<const Patch*>& patches, const std::vector<std::string>& names,
                       double tolerance, const std::vector<std::vector<Join>>& join,
                       const std::function<bool(const PatchPoint&)>& held = {}, const std::vector<int>& whole = {});

}  // namespace sunder::shell
