#pragma once
// Patches of common shape. Arcs are exact, so they are rational; a patch spans less than 150 degrees of one.
#include "shell/geometry/patch.h"

namespace sunder::shell {

constexpr double kWidestArc = 150.0 * 3.14159265358979323846 / 180.0;  // [rad]: weights fall with the cosine of half

/// Each span of the patch cut into equal spans until there are `elements_u` * `elements_v`, the surface
/// unchanged (Boehm's knot insertion). Both must be multiples of the spans there are.
Patch refined(const Patch& patch, int elements_u, int elements_v);
/// The same surface with no span longer than a `least_u`-th (`least_v`-th) of the domain; each is cut into equal
/// spans, so there are at least as many as asked for.
Patch refined_at_least(const Patch& patch, int least_u, int least_v);

/// Profile points (a conic arc or line as three points, weights) about the z axis through `angle` [rad] from
/// the x axis; u runs along the angle, v along the profile. Profile points are (radius, height).
Patch revolved(const std::array<Vec2, 3>& profile, const std::array<double, 3>& weights, double angle);

/// The same surface as a cubic patch. `patch` is quadratic and one span, as revolved() gives it: refine afterwards.
Patch elevated(const Patch& patch);

/// Sector of a cylinder about z, from z = 0 to `length`, its middle over the x axis: u along the arc.
Patch cylinder(double radius, double length, double angle, int elements_u, int elements_v, int degree = 2);
/// Sector of a sphere about its centre, the angle about z from the x axis; v from polar angle `from` to `to`
/// [rad], 0 at the equator, pi / 2 at the pole.
Patch sphere(double radius, double angle, double from, double to, int elements_u, int elements_v, int degree = 2);
/// Sector of a cone about z: radius `bottom` at z = 0, `top` (may be 0) at z = `height`.
Patch cone(double bottom, double top, double height, double angle, int elements_u, int elements_v, int degree = 2);

/// The patch turned, then moved.
Patch placed(Patch patch, const Vec3& position, const Quat& orientation);

}  // namespace sunder::shell
