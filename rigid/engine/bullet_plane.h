#pragma once
// Contacts of a shape with a half space by its true corners. Private to the adapter. Bullet's own algorithm finds one
// corner per query, on the rounded hull. Flat plates would rock on the few points found so far, and sharp corners would
// sink in by their rounding.
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>

#include <vector>

namespace sunder::rigid {

/// Points of a shape that may touch a plane, in the shape's coordinates, with a radius. The shape's user pointer leads
/// to it.
struct PlanePoints {
  std::vector<btVector3> points;
  double radius = 0.0;
};

/// Makes Bullet's contact algorithm for (shape, plane), or for (plane, shape).
class PlaneCreateFunc final : public btCollisionAlgorithmCreateFunc {
 public:
  explicit PlaneCreateFunc(bool plane_first) { m_swapped = plane_first; }
  btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                 const btCollisionObjectWrapper* first,
                                                 const btCollisionObjectWrapper* second) override;
  static int algorithm_size();  // [bytes], for Bullet's pool
};

}  // namespace sunder::rigid
