#pragma once
// Contact of a shape with a half space by its true corners. Private to the adapter.
// Bullet's own algorithm finds one corner per query, on the rounded hull: flat plates rock on the few
// points that it has gathered, and sharp corners sink in by what the rounding took.
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>

#include <vector>

namespace sunder::rigid {

/// What may touch a plane, in the shape's coordinates: points with a radius around each. A shape
/// carries it as its user pointer.
struct PlanePoints {
  std::vector<btVector3> points;
  double radius = 0.0;
};

/// One for (shape, plane) and one for (plane, shape).
class PlaneCreateFunc final : public btCollisionAlgorithmCreateFunc {
 public:
  explicit PlaneCreateFunc(bool plane_first) { m_swapped = plane_first; }
  btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                 const btCollisionObjectWrapper* first,
                                                 const btCollisionObjectWrapper* second) override;
  static int algorithm_size();  // [bytes], for Bullet's pool
};

}  // namespace sunder::rigid
