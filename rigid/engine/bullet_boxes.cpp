#include "rigid/engine/bullet_boxes.h"

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>

#include <new>

#include "rigid/engine/bullet_shapes.h"
#include "rigid/engine/touch.h"

namespace sunder::rigid {
namespace {

/// A contact point that moves less than this on the first body between two windows starts from its old impulse.
constexpr double kSamePlace_m = 2e-3;

Hull hull_of(const btCollisionObjectWrapper* object) {
  const btVector3 half = static_cast<const btBoxShape*>(object->getCollisionShape())->getHalfExtentsWithMargin();
  RigidBody box;
  box.shape = BoxShape{Vec3(half.x(), half.y(), half.z()) / kLengthScale};
  return make_hull_shape(box).parts.front();
}

BodyMotion pose_of(const btCollisionObjectWrapper* object) {
  const btTransform& at = object->getWorldTransform();
  const btQuaternion turn = at.getRotation();
  BodyMotion motion;
  motion.position = Vec3(at.getOrigin().x(), at.getOrigin().y(), at.getOrigin().z()) / kLengthScale;
  motion.orientation = Quat(turn.w(), turn.x(), turn.y(), turn.z());
  return motion;
}

btVector3 to_bullet(const Vec3& p) { return btVector3(p.x(), p.y(), p.z()) * kLengthScale; }

class BoxesAlgorithm final : public btCollisionAlgorithm {
 public:
  BoxesAlgorithm(const btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* first,
                 const btCollisionObjectWrapper* second)
      : btCollisionAlgorithm(info),
        manifold_(m_dispatcher->getNewManifold(first->getCollisionObject(), second->getCollisionObject())),
        first_(hull_of(first)),
        second_(hull_of(second)) {}
  ~BoxesAlgorithm() override { m_dispatcher->releaseManifold(manifold_); }

  void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                        const btDispatcherInfo&, btManifoldResult*) override {
    place(first_, pose_of(first), first_placed_);
    place(second_, pose_of(second), second_placed_);
    touches_.clear();
    touch_hulls(first_placed_, second_placed_, manifold_->getContactBreakingThreshold() / kLengthScale, touches_);
    btManifoldPoint old[MANIFOLD_CACHE_SIZE];
    const int old_count = manifold_->getNumContacts();
    for (int i = 0; i < old_count; ++i) old[i] = manifold_->getContactPoint(i);
    bool taken[MANIFOLD_CACHE_SIZE] = {};
    manifold_->clearManifold();
    for (const Touch& touch : touches_) {
      const btVector3 on_first = to_bullet(touch.first), on_second = to_bullet(touch.second);
      btManifoldPoint point(first->getWorldTransform().invXform(on_first),
                            second->getWorldTransform().invXform(on_second), to_bullet(touch.normal) / kLengthScale,
                            kLengthScale * touch.gap);
      point.m_positionWorldOnA = on_first;
      point.m_positionWorldOnB = on_second;
      int nearest = -1;
      double least = kLengthScale * kSamePlace_m;
      for (int i = 0; i < old_count; ++i) {
        const double moved = (old[i].m_localPointA - point.m_localPointA).length();
        if (!taken[i] && moved < least) nearest = i, least = moved;
      }
      if (nearest >= 0) {
        taken[nearest] = true;
        point.m_appliedImpulse = old[nearest].m_appliedImpulse;
      }
      manifold_->addManifoldPoint(point);
    }
  }

  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override {
    return 1.0;  // nothing here asks for continuous collision
  }

  void getAllContactManifolds(btManifoldArray& all) override { all.push_back(manifold_); }

 private:
  btPersistentManifold* manifold_;
  Hull first_, second_;                // in body coordinates [m]
  Hull first_placed_, second_placed_;  // in world coordinates [m]
  std::vector<Touch> touches_;
};

}  // namespace

btCollisionAlgorithm* BoxesCreateFunc::CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                                const btCollisionObjectWrapper* first,
                                                                const btCollisionObjectWrapper* second) {
  return new (info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(BoxesAlgorithm)))
      BoxesAlgorithm(info, first, second);
}

int BoxesCreateFunc::algorithm_size() { return static_cast<int>(sizeof(BoxesAlgorithm)); }

}  // namespace sunder::rigid
