#pragma once
// Contact of two boxes by their true faces (touch.h). Private to the adapter.
// Bullet's own finder sees boxes only once they overlap, so plates that lie on one another sink and creep.
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>

namespace sunder::rigid {

class BoxesCreateFunc final : public btCollisionAlgorithmCreateFunc {
 public:
  btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                 const btCollisionObjectWrapper* first,
                                                 const btCollisionObjectWrapper* second) override;
  static int algorithm_size();  // [bytes], for Bullet's pool
};

}  // namespace sunder::rigid
