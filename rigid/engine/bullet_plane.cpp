#include "rigid/engine/bullet_plane.h"

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <new>

namespace sunder::rigid {
namespace {

class PlaneAlgorithm final : public btCollisionAlgorithm {
 public:
  PlaneAlgorithm(const btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* shape,
                 const btCollisionObjectWrapper* plane, bool plane_first)
      : btCollisionAlgorithm(info), plane_first_(plane_first) {
    const auto& points = static_cast<const PlanePoints*>(shape->getCollisionShape()->getUserPointer())->points;
    // Corner k is always in manifold k/4, since a manifold holds four points: no corner replaces another one.
    for (std::size_t k = 0; k < points.size(); k += 4)
      manifolds_.push_back(m_dispatcher->getNewManifold(shape->getCollisionObject(), plane->getCollisionObject()));
  }
  ~PlaneAlgorithm() override {
    for (btPersistentManifold* manifold : manifolds_) m_dispatcher->releaseManifold(manifold);
  }

  void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                        const btDispatcherInfo& info, btManifoldResult*) override {
    const btCollisionObjectWrapper* shape = plane_first_ ? second : first;
    const btCollisionObjectWrapper* plane = plane_first_ ? first : second;
    const auto& tops = *static_cast<const PlanePoints*>(shape->getCollisionShape()->getUserPointer());
    const auto& flat = *static_cast<const btStaticPlaneShape*>(plane->getCollisionShape());
    const btTransform &pose = shape->getWorldTransform(), &plane_pose = plane->getWorldTransform();
    const btVector3 normal = plane_pose.getBasis() * flat.getPlaneNormal();
    const double offset = normal.dot(plane_pose * (flat.getPlaneConstant() * flat.getPlaneNormal()));
    const btRigidBody& body = *btRigidBody::upcast(shape->getCollisionObject());
    const btTransform to_body = body.getWorldTransform().inverse();
    for (std::size_t m = 0; m < manifolds_.size(); ++m) {
      btPersistentManifold& manifold = *manifolds_[m];
      btManifoldPoint old[4];
      const int old_count = manifold.getNumContacts();
      for (int i = 0; i < old_count; ++i) old[i] = manifold.getContactPoint(i);
      manifold.clearManifold();
      for (std::size_t k = 4 * m; k < std::min(4 * m + 4, tops.points.size()); ++k) {
        const btVector3 corner = pose * tops.points[k];
        const double gap = normal.dot(corner) - offset - tops.radius;
        // Include each corner that can arrive in this window, so that fast bodies do not sink in.
        const btVector3 velocity = body.getVelocityInLocalPoint(corner - body.getCenterOfMassPosition());
        const double approach = std::max(0.0, -normal.dot(velocity)) * info.m_timeStep;
        if (gap > manifold.getContactBreakingThreshold() + approach) continue;
        const btVector3 on_shape = corner - tops.radius * normal, on_plane = on_shape - gap * normal;
        btManifoldPoint point(to_body * on_shape, plane_pose.inverse() * on_plane, normal, gap);
        point.m_positionWorldOnA = on_shape;
        point.m_positionWorldOnB = on_plane;
        point.m_index0 = static_cast<int>(k);
        for (int i = 0; i < old_count; ++i)  // the solver starts from it
          if (old[i].m_index0 == point.m_index0) point.m_appliedImpulse = old[i].m_appliedImpulse;
        manifold.addManifoldPoint(point);
      }
    }
  }

  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override {
    return 1.0;  // nothing here asks for continuous collision
  }

  void getAllContactManifolds(btManifoldArray& all) override {
    for (btPersistentManifold* manifold : manifolds_) all.push_back(manifold);
  }

 private:
  bool plane_first_;
  std::vector<btPersistentManifold*> manifolds_;
};

}  // namespace

btCollisionAlgorithm* PlaneCreateFunc::CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                                const btCollisionObjectWrapper* first,
                                                                const btCollisionObjectWrapper* second) {
  void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(PlaneAlgorithm));
  return new (memory) PlaneAlgorithm(info, m_swapped ? second : first, m_swapped ? first : second, m_swapped);
}

int PlaneCreateFunc::algorithm_size() { return static_cast<int>(sizeof(PlaneAlgorithm)); }

}  // namespace sunder::rigid
