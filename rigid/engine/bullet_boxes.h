#pragma once
// Contacts of two boxes by their true faces (touch.h). Private to the adapter. Bullet's own finder reports boxes only
// in an overlap, so plates on one another would sink and creep.
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>

namespace sunder::rigid {

/// Makes Bullet's contact algorithm for two boxes.
class BoxesCreateFunc final : public btCollisionAlgorithmCreateFunc {
 public:
  btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                 const btCollisionObjectWrapper* first,
                                                 const btCollisionObjectWrapper* second) override;
  static int algorithm_size();  // [bytes], for Bullet's pool
};

}  // namespace sunder::rigid
