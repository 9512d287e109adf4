#pragma once
// Shapes for Bullet. Private to the adapter: only bullet_*.cpp may include this.
#include <btBulletCollisionCommon.h>

#include <memory>
#include <vector>

#include "coupler/core/body.h"
#include "rigid/engine/bullet_plane.h"

namespace sunder::rigid {

/// Units in Bullet: lengths in cm, masses in g. In SI the inertia of a 20 mm shard is below Bullet's absolute
/// tolerances.
constexpr double kLengthScale = 100.0;  // [1/m]
constexpr double kMassScale = 1000.0;   // [1/kg]
/// Rounding radius of hulls and boxes. Bullet's default of 0.04 units would leave visible gaps between shards.
constexpr double kMargin_m = 0.5e-3;

/// A Bullet shape with the objects that it points to but does not own.
struct BulletShape {
  std::vector<std::unique_ptr<PlanePoints>> plane_points;
  std::vector<std::unique_ptr<btCollisionShape>> children;
  std::unique_ptr<btCollisionShape> compound;  // null where there is one child only

  btCollisionShape* get() const { return compound ? compound.get() : children.front().get(); }
};

/// Shape of a body that check_body() accepts. Throws Error (bad_body) with id, name, value and remedy where a convex
/// part has too few corners, is not finite, or is flat.
BulletShape make_bullet_shape(const RigidBody& body);

}  // namespace sunder::rigid
