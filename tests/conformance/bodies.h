#pragma once
// Makes bodies with exact mass and inertia.
#include <random>
#include <vector>

#include "coupler/core/body.h"

namespace sunder::conformance {

constexpr double kGlass = 2500.0;  // [kg/m^3]

using Polygon = std::vector<Vec2>;  // convex, anticlockwise [m]

RigidBody sphere(BodyId id, double radius_m);
RigidBody box(BodyId id, const Vec3& half_size_m);
/// The half space below z = 0, turned by `tilt`.
RigidBody half_space(BodyId id, const Quat& tilt = Quat::Identity());
/// A plate of convex polygons [m] that share edges, extruded by +- thickness/2 about z = 0. The body has the plate's
/// principal axes and place.
RigidBody plate(BodyId id, const std::vector<Polygon>& polygons, double thickness_m);
Polygon rectangle(double x0, double y0, double x1, double y1);

RigidBody fixed(RigidBody body);
RigidBody at(RigidBody body, const Vec3& position);
RigidBody moving(RigidBody body, const Vec3& velocity, const Vec3& spin_rad_s = Vec3::Zero());
RigidBody turned(RigidBody body, const Vec3& rotation_rad);

/// A random number in [low, high), the same with every standard library.
double uniform(std::mt19937& random, double low, double high);

/// Plates 20 to 60 mm wide and 3 mm thick that fall and turn, from different heights. With `compounds`, every third one
/// is an L of two parts. Ids count from `first`.
std::vector<RigidBody> thrown_plates(BodyId first, int count, bool compounds);

}  // namespace sunder::conformance
