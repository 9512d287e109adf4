#pragma once
// Curves in a parameter plane, their division into crack edges, and a test whether a polyline meets itself.
#include <functional>
#include <optional>
#include <vector>

#include "coupler/core/vec.h"

namespace sunder::shell {

/// A curve over t from 0 to 1. `length` is an estimate, nearly always from above. A closed curve has the same point at
/// 0 and 1.
struct PlaneCurve {
  std::function<Vec2(double)> at;
  double length = 0.0;  // [m]
  bool closed = false;
};

/// Circle, counter-clockwise, starting in the direction of u from `centre` [m].
PlaneCurve circle_curve(const Vec2& centre, double radius);
/// Archimedean spiral, counter-clockwise, starting in the direction of u: the radius [m] grows linearly with the angle.
PlaneCurve spiral_curve(const Vec2& centre, double inner, double outer, double turns);
/// B-spline of uniform knots. An open one is clamped at its end points and has at least degree + 1 points; a closed one
/// is smooth.
PlaneCurve spline_curve(const std::vector<Vec2>& points, int degree, bool closed);

/// Shortest edge of a cut; a polyline with shorter edges loses points [spacings].
constexpr double kShortestEdge = 0.5;
/// Largest distance of a chord from its arc, and of a removed point from the line [spacings].
constexpr double kSag = 0.01;

/// Samples a curve densely: about sixteen points for each `spacing` [m], within fixed limits.
std::vector<Vec2> fine_points(const PlaneCurve& curve, double spacing);

/// Divides a curve into a whole number of edges of 0.9 `spacing` [m] or a little more; below two of these the whole
/// curve is one edge. Edges are shorter, down to half a spacing, where the curve bends: a chord then stays within a
/// hundredth of a spacing of the curve, as far as that limit allows. A closed curve has at least eight edges, and its
/// last point equals its first exactly.
std::vector<Vec2> crack_points(const PlaneCurve& curve, double spacing);
/// The same as parameters of the curve, from 0 to 1.
std::vector<double> crack_parameters(const PlaneCurve& curve, double spacing);

/// Removes points within `tolerance` [m] of the remaining polyline (Douglas and Peucker 1973). Both ends stay. A closed
/// polyline, whose last point equals its first exactly, keeps at least three corners.
std::vector<Vec2> thinned(const std::vector<Vec2>& points, double tolerance);

/// Where segments ab and cd cross or touch, within `tolerance` [m].
std::optional<Vec2> segments_touch(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d, double tolerance);

/// Two segments that meet; segment k runs from points[k] to points[k + 1]. The end that two neighbours share does not
/// count.
struct Meeting {
  int first, second;
  Vec2 at;
};
/// Finds the first two segments of a polyline that cross, touch (within `tolerance` [m]) or fold back on each other. A
/// polyline whose last point equals its first exactly is closed; that common point does not count.
std::optional<Meeting> meets_itself(const std::vector<Vec2>& points, double tolerance);

}  // namespace sunder::shell
