#pragma once
// Contacts of two boxes, and of fast hulls, by their true faces (touch.h). Private to the adapter. Bullet's own finder
// reports boxes only in an overlap, so plates on one another would sink and creep. Of hulls it finds one point a window
// and collects further ones over several windows. A hull that comes fast would turn about the first point and be in or
// behind the other body before the second is found.
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btConvexConvexAlgorithm.h>

namespace sunder::rigid {

/// Makes Bullet's contact algorithm for two boxes.
class BoxesCreateFunc final : public btCollisionAlgorithmCreateFunc {
 public:
  btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                 const btCollisionObjectWrapper* first,
                                                 const btCollisionObjectWrapper* second) override;
  static int algorithm_size();  // [bytes], for Bullet's pool
};

/// Makes the contact algorithm for two hulls, or a hull and a box. It is Bullet's own for slow pairs.
class HullsCreateFunc final : public btConvexConvexAlgorithm::CreateFunc {
 public:
  explicit HullsCreateFunc(btConvexPenetrationDepthSolver* depth_solver);
  btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                 const btCollisionObjectWrapper* first,
                                                 const btCollisionObjectWrapper* second) override;
  static int algorithm_size();  // [bytes], for Bullet's pool
};

}  // namespace sunder::rigid
