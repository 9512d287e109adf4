#include "coupler/core/body.h"

#include "coupler/core/free_rotation.h"

namespace sunder {

Vec3 RigidBody::apply_inverse_inertia(const Vec3& world) const {
  const Vec3 local = motion.orientation.conjugate() * world;
  return motion.orientation * local.cwiseQuotient(principal_inertia);
}

Vec3 RigidBody::apply_inertia(const Vec3& world) const {
  const Vec3 local = motion.orientation.conjugate() * world;
  return motion.orientation * local.cwiseProduct(principal_inertia);
}

Vec3 RigidBody::angular_velocity() const {
  return is_static ? Vec3(Vec3::Zero()) : apply_inverse_inertia(motion.angular_momentum);
}

double RigidBody::kinetic_energy() const {
  if (is_static) return 0.0;
  return 0.5 * mass * motion.velocity.squaredNorm() + 0.5 * motion.angular_momentum.dot(angular_velocity());
}

void RigidBody::drift(double h) {
  motion.position += h * motion.velocity;
  motion.orientation = free_rotation(principal_inertia, motion.angular_momentum, motion.orientation, h);
}

}  // namespace sunder
