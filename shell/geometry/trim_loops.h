#pragma once
// Trim loops: closed polylines in the parameter domain of a patch. They tell which part of the patch exists.
#include <vector>

#include "coupler/core/vec.h"
#include "shell/geometry/plane_curves.h"

namespace sunder::shell {

/// One closed polyline; its last point equals its first exactly.
struct TrimLoop {
  std::vector<Vec2> points;
  bool hole = false;                 // the inside of the loop is cut away; otherwise the outside is
  std::vector<PlaneCurve> curves{};  // in the order of the points, which are near them; empty: the polyline itself
};

/// A place in the parameter domain and the parameter area [m^2] that it stands for.
struct WeightedPlace {
  Vec2 at;
  double area;
};

/// The region that an outline and holes leave of a rectangle. At most one loop is an outline. Loops neither cross nor
/// touch themselves or each other.
class TrimLoops {
 public:
  TrimLoops() = default;
  /// Loops in a domain from `low` to `high`. Outlines are turned counter-clockwise and holes clockwise, so that the
  /// region lies on the left of each edge.
  TrimLoops(const Vec2& low, const Vec2& high, std::vector<TrimLoop> loops);

  bool empty() const { return loops_.empty(); }
  const std::vector<TrimLoop>& loops() const { return loops_; }
  /// Whether p belongs to the region. Points on a loop, to round-off, do.
  bool contains(const Vec2& p) const;
  /// Returns p where it is inside, or else the nearest place that is `depth` [m] inside of the nearest loop.
  Vec2 moved_inside(const Vec2& p, double depth) const;
  /// Area of the region in the domain [m^2].
  double area() const;
  /// Whether an edge of a loop may pass through the box.
  bool cuts(const Vec2& low, const Vec2& high) const;
  /// Quadrature of the part of the region in the box, with `most` places at most and positive areas. Four places
  /// integrate polynomials of degree 2 exactly; more of them divide the part into as many groups of four. A part that
  /// is small, or that such places would leave, has one place and degree 0. Empty where the region leaves nothing.
  std::vector<WeightedPlace> places_in(const Vec2& low, const Vec2& high, int most) const;

 private:
  Vec2 low_ = Vec2::Zero(), high_ = Vec2::Zero();
  double tolerance_ = 0.0;  // distance at which a point is on a loop [m]
  bool outlined_ = false;
  std::vector<TrimLoop> loops_;
  // Edges by strips of the second coordinate: the first point of each, as loop and index.
  struct Edge {
    Vec2 a, b;
  };
  std::vector<std::vector<Edge>> strips_;
  double strip_ = 1.0;  // height of a strip [m]
  int strip_of(double y) const;
};

}  // namespace sunder::shell
