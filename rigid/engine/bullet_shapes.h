#pragma once
// Shapes for Bullet. Private to the adapter: only bullet_*.cpp may include this.
#include <btBulletCollisionCommon.h>

#include <memory>
#include <vector>

#include "coupler/core/body.h"
#include "rigid/engine/bullet_plane.h"

namespace sunder::rigid {

/// Bullet's length unit is 1 cm and its mass unit 1 g. In SI a 20 mm shard has entries of inertia
/// below Bullet's absolute tolerances.
constexpr double kLengthScale = 100.0;  // [1/m]
constexpr double kMassScale = 1000.0;   // [1/kg]
/// Rounding of hulls and boxes. Bullet's own 0.04 would hold shards visibly apart in SI.
constexpr double kMargin_m = 0.5e-3;

/// A Bullet shape with what it points to but does not own.
struct BulletShape {
  std::vector<std::unique_ptr<PlanePoints>> plane_points;
  std::vector<std::unique_ptr<btCollisionShape>> children;
  std::unique_ptr<btCollisionShape> compound;  // null where there is one child only

  btCollisionShape* get() const { return compound ? compound.get() : children.front().get(); }
};

/// Of a body that check_body() lets through. Throws Error (bad_body) with id, name, value and remedy where a convex
/// part cannot be held.
BulletShape make_bullet_shape(const RigidBody& body);

}  // namespace sunder::rigid
