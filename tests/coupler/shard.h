#pragma once
// A body with a value in every field.
#include "coupler/core/body.h"

namespace sunder {

inline RigidBody shard() {
  RigidBody b;
  b.id = 3, b.name = "shard_3", b.mass = 0.2, b.principal_inertia = {1e-4, 2e-4, 2.5e-4};
  b.motion.position = {0.1, -0.2, 0.3}, b.motion.orientation = Quat(0.5, 0.5, -0.5, 0.5);
  b.motion.velocity = {1, 2, 3}, b.motion.angular_momentum = {1e-3, 0, -1e-3};
  b.shape = ConvexShape{{{{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}}}};
  return b;
}

}  // namespace sunder
