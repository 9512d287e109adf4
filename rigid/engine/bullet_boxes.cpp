#include "rigid/engine/bullet_boxes.h"

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>

#include <algorithm>
#include <new>
#include <optional>

#include "coupler/core/error.h"
#include "rigid/engine/bullet_plane.h"
#include "rigid/engine/bullet_shapes.h"
#include "rigid/engine/touch.h"

namespace sunder::rigid {
namespace {

/// A contact point that moves less than this on the first body between two windows starts from its old impulse.
constexpr double kSamePlace_m = 2e-3;

/// A pair is fast where it approaches by more than this share of the smaller one's bounding radius in a window.
constexpr double kFastApproach = 0.25;  // [-]

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

btManifoldPoint point_of(const Touch& touch, const btCollisionObjectWrapper* first,
                         const btCollisionObjectWrapper* second) {
  const btVector3 on_first = to_bullet(touch.first), on_second = to_bullet(touch.second);
  btManifoldPoint point(first->getWorldTransform().invXform(on_first), second->getWorldTransform().invXform(on_second),
                        to_bullet(touch.normal) / kLengthScale, kLengthScale * touch.gap);
  point.m_positionWorldOnA = on_first;
  point.m_positionWorldOnB = on_second;
  return point;
}

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
      btManifoldPoint point = point_of(touch, first, second);
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

double bounding_radius(const btCollisionObjectWrapper* object) {
  btVector3 centre;
  btScalar radius = 0.0;
  object->getCollisionShape()->getBoundingSphere(centre, radius);
  return radius;
}

class HullsAlgorithm final : public btConvexConvexAlgorithm {
 public:
  using btConvexConvexAlgorithm::btConvexConvexAlgorithm;

  void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                        const btDispatcherInfo& how, btManifoldResult* result) override {
    btConvexConvexAlgorithm::processCollision(first, second, how, result);
    btManifoldArray mine;
    getAllContactManifolds(mine);
    if (mine.size() == 0) return;
    btPersistentManifold& manifold = *mine[0];
    const double reach = manifold.getContactBreakingThreshold();
    if (reach <= kFastApproach * std::min(bounding_radius(first), bounding_radius(second))) return;
    if (!tried_) read_faces(first, second);
    if (!faces_) return;
    place(faces_->first, pose_of(first), faces_->first_placed);
    place(faces_->second, pose_of(second), faces_->second_placed);
    touches_.clear();
    touch_hulls(faces_->first_placed, faces_->second_placed, reach / kLengthScale, touches_);
    manifold.clearManifold();
    for (const Touch& touch : touches_) {
      btManifoldPoint point = point_of(touch, first, second);
      manifold.addManifoldPoint(point);
    }
  }

 private:
  struct Faces {
    Hull first, second;                // in body coordinates [m]
    Hull first_placed, second_placed;  // in world coordinates [m]
  };

  void read_faces(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second) {
    tried_ = true;
    const auto hull = [](const btCollisionObjectWrapper* object) {
      RigidBody body;
      ConvexShape shape{{{}}};
      for (const btVector3& p : static_cast<const PlanePoints*>(object->getCollisionShape()->getUserPointer())->points)
        shape.parts[0].emplace_back(Vec3(p.x(), p.y(), p.z()) / kLengthScale);
      body.shape = std::move(shape);
      return make_hull_shape(body).parts.front();
    };
    try {
      faces_ = Faces{hull(first), hull(second), {}, {}};
    } catch (const Error&) {
      // Corners that nearly coincide define no faces, though Bullet takes them: its own finder remains.
    }
  }

  bool tried_ = false;
  std::optional<Faces> faces_;  // from the first fast window on
  std::vector<Touch> touches_;
};

}  // namespace

HullsCreateFunc::HullsCreateFunc(btConvexPenetrationDepthSolver* depth_solver) : CreateFunc(depth_solver) {
  // one point is too few for two plates
  m_numPerturbationIterations = m_minimumPointsPerturbationThreshold = 3;
}

btCollisionAlgorithm* HullsCreateFunc::CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                                const btCollisionObjectWrapper* first,
                                                                const btCollisionObjectWrapper* second) {
  return new (info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(HullsAlgorithm)))
      HullsAlgorithm(info.m_manifold, info, first, second, m_pdSolver, m_numPerturbationIterations,
                     m_minimumPointsPerturbationThreshold);
}

int HullsCreateFunc::algorithm_size() { return static_cast<int>(sizeof(HullsAlgorithm)); }

btCollisionAlgorithm* BoxesCreateFunc::CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                                const btCollisionObjectWrapper* first,
                                                                const btCollisionObjectWrapper* second) {
  return new (info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(BoxesAlgorithm)))
      BoxesAlgorithm(info, first, second);
}

int BoxesCreateFunc::algorithm_size() { return static_cast<int>(sizeof(BoxesAlgorithm)); }

}  // namespace sunder::rigid
