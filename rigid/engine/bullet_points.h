#pragma once
// Points of Bullet's contacts: where they are on a body, where they act, and the speed at which they open.
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <btBulletDynamicsCommon.h>

namespace sunder::rigid {

inline btVector3 velocity_at(const btCollisionObject& object, const btVector3& world_point) {
  const btRigidBody* body = btRigidBody::upcast(&object);
  return body->getVelocityInLocalPoint(world_point - body->getCenterOfMassPosition());
}

inline bool is_ball(const btCollisionObject& object) {
  return object.getCollisionShape()->getShapeType() == SPHERE_SHAPE_PROXYTYPE;
}

/// A contact's point of a body at its present pose. That of a ball is where the normal through its centre leaves it,
/// and does not turn with the ball. `side`: 1 where the normal points into the body, -1 where it points out.
inline btVector3 point_on(const btCollisionObject& object, const btVector3& local, const btVector3& normal,
                          double side) {
  if (!is_ball(object)) return object.getWorldTransform() * local;
  const double radius = static_cast<const btSphereShape*>(object.getCollisionShape())->getRadius();
  return object.getWorldTransform().getOrigin() - side * radius * normal;
}

/// Moves both points of a contact to one: that of a ball, else their middle. Bullet applies the impulse to each body at
/// its own point. Where these are apart, friction, or a normal that has turned, would create angular momentum.
inline void act_at_one_point(btManifoldPoint& point, const btCollisionObject& a, const btCollisionObject& b) {
  btVector3 &on_a = point.m_positionWorldOnA, &on_b = point.m_positionWorldOnB;
  on_a = on_b = is_ball(a) ? on_a : is_ball(b) ? on_b : 0.5 * (on_a + on_b);
}

/// Sets the speed at which a contact opens after a solve. Bullet's target velocity is -distance * erp / H.
inline void set_target(btManifoldPoint& point, double speed, double window_s) {
  point.setDistance(-speed * window_s);
  point.m_contactPointFlags |= BT_CONTACT_FLAG_HAS_CONTACT_ERP;
  point.m_contactERP = 1.0;
}

}  // namespace sunder::rigid
