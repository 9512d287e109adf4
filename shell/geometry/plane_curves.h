#pragma once
// Curves in a parameter plane as polylines whose edges suit a crack, and where a polyline meets itself.
#include <functional>
#include <optional>
#include <vector>

#include "coupler/core/vec.h"

namespace sunder::shell {

/// A curve over t from 0 to 1. `length` is at least its length, or about; closed: the point of 1 is that of 0.
struct PlaneCurve {
  std::function<Vec2(double)> at;
  double length = 0.0;  // [m]
  bool closed = false;
};

/// Counter-clockwise, from the direction of u.
PlaneCurve circle_curve(const Vec2& centre, double radius);
/// Archimedean, counter-clockwise from the direction of u: the radius grows evenly with the angle.
PlaneCurve spiral_curve(const Vec2& centre, double inner, double outer, double turns);
/// B-spline of uniform knots: open and clamped at its end points (at least degree + 1 points), or closed and smooth.
PlaneCurve spline_curve(const std::vector<Vec2>& points, int degree, bool closed);

/// Shortest edge of a cut; a polyline that has shorter ones loses points [spacings].
constexpr double kShortestEdge = 0.5;
/// Distance from a chord to its arc, and of a point that is left out from the line [spacings].
constexpr double kSag = 0.01;

/// Points of the curve, many to a spacing.
std::vector<Vec2> fine_points(const PlaneCurve& curve, double spacing);

/// Points of the curve, edges of about `spacing`, shorter where it bends: down to half of that, so that a chord is
/// within a hundredth of a spacing of the curve where that is enough. At least eight edges where it is closed. The last
/// point of a closed curve is exactly the first.
std::vector<Vec2> crack_points(const PlaneCurve& curve, double spacing);

/// The polyline without points that lie within `tolerance` of what is left (Douglas and Peucker 1973). Both ends stay;
/// of a closed one, whose last point is exactly the first, at least three corners.
std::vector<Vec2> thinned(const std::vector<Vec2>& points, double tolerance);

/// Segments k, from points[k] to points[k + 1], that meet elsewhere than in the end that neighbours share.
struct Meeting {
  int first, second;
  Vec2 at;
};
/// The first two segments of a polyline that cross, touch (within `tolerance`) or fold back on one another. Where the
/// last point is exactly the first it is closed, and meets itself there with every right.
std::optional<Meeting> meets_itself(const std::vector<Vec2>& points, double tolerance);

}  // namespace sunder::shell
