#pragma once
// Builders of patches of common shape. Arcs are exact, which needs rational patches. One patch spans less than 150
// degrees of an arc.
#include "shell/geometry/patch.h"

namespace sunder::shell {

constexpr double kWidestArc = 150.0 * 3.14159265358979323846 / 180.0;  // [rad]; the middle weight is cos(angle / 2)

/// Divides each span of positive length into equal spans until the patch has `elements_u` x `elements_v` of them. The
/// surface does not change (knot insertion, Boehm 1980). Throws Error where a number of elements is not a multiple of
/// the number of spans.
Patch refined(const Patch& patch, int elements_u, int elements_v);
/// Divides spans into equal parts until none is longer than the domain divided by `least_u` (`least_v`). The surface
/// does not change. The patch then has at least that many elements. Throws Error where either number is below 1.
Patch refined_at_least(const Patch& patch, int least_u, int least_v);

/// Turns a profile about the z axis through `angle` [rad], starting at the x axis. The profile is a conic arc or a
/// line, given by three points (radius, height) [m] and their weights. u runs along the angle, v along the profile.
/// Throws Error where the angle is not between 0 and kWidestArc.
Patch revolved(const std::array<Vec2, 3>& profile, const std::array<double, 3>& weights, double angle);

/// Raises a quadratic patch of one span, as revolved() returns it, to degree 3. The surface does not change. Throws
/// Error for any other patch: refine afterwards.
Patch elevated(const Patch& patch);

/// Sector of a cylinder about z [m, rad] from z = 0 to `length`, its middle above the x axis. u runs along the arc.
Patch cylinder(double radius, double length, double angle, int elements_u, int elements_v, int degree = 2);
/// Sector of a sphere about its centre [m]. u runs about z from the x axis through `angle` [rad]. v runs from latitude
/// `from` to latitude `to` [rad]: 0 at the equator, pi / 2 at the pole. Throws Error where the latitudes do not rise or
/// leave that range.
Patch sphere(double radius, double angle, double from, double to, int elements_u, int elements_v, int degree = 2);
/// Sector of a cone about z [m, rad]: radius `bottom` at z = 0 and `top` (may be 0) at z = `height`. u runs along the
/// arc.
Patch cone(double bottom, double top, double height, double angle, int elements_u, int elements_v, int degree = 2);

/// Returns the patch turned by `orientation`, then moved by `position` [m].
Patch placed(Patch patch, const Vec3& position, const Quat& orientation);

}  // namespace sunder::shell
