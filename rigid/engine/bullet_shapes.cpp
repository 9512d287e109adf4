#include "rigid/engine/bullet_shapes.h"

#include <LinearMath/btConvexHullComputer.h>

#include <algorithm>
#include <cmath>

#include "coupler/core/convex_surface.h"
#include "rigid/engine/checks.h"

namespace sunder::rigid {
namespace {

/// Largest share of the distance from the centre to the nearest face that shrinking may take. So a sliver thinner than
/// two margins keeps a core. Its margin is what shrinking took, so its size does not change.
constexpr double kShrinkClamp = 0.45;  // [-]
/// Shrinking and rounding cuts sharp corners by margin * (1/sin(half angle) - 1). Where the cut is larger than this,
/// the margin is halved.
constexpr double kMaxCornerLoss_m = 0.7e-3;
/// Least margin. Below it the hull keeps its corners and has this margin: GJK in double precision works with 1 um.
constexpr double kLeastMargin_m = 1e-6;
btVector3 scaled(const Vec3& p) { return btVector3(kLengthScale * p.x(), kLengthScale * p.y(), kLengthScale * p.z()); }

/// Largest distance of a corner from the shrunk and rounded hull [Bullet lengths]. An upper bound: it considers the
/// corners of the shrunk hull only.
double corner_loss(const btConvexHullComputer& unshrunk, const btConvexHullComputer& shrunk, double margin) {
  double worst = 0.0;
  for (int i = 0; i < unshrunk.vertices.size(); ++i) {
    double nearest = BT_LARGE_FLOAT;
    for (int k = 0; k < shrunk.vertices.size(); ++k)
      nearest = std::min(nearest, (shrunk.vertices[k] - unshrunk.vertices[i]).length());
    worst = std::max(worst, nearest - margin);
  }
  return worst;
}

std::unique_ptr<btCollisionShape> make_hull(const RigidBody& body, const std::vector<Vec3>& part, std::size_t index) {
  const std::string field = fmt::format("shape.parts[{}]", index);
  const double diagonal = check_corners(body, part, field);
  // Bullet computes hulls on a grid of 1e-4 of their size, on which a thin tilted part is flat.
  check_not_flat(body, convex_surface(part), diagonal, field);
  std::vector<btVector3> corners;
  for (const Vec3& p : part) corners.push_back(scaled(p));
  const int count = static_cast<int>(corners.size());
  const auto compute = [&](btConvexHullComputer& hull, double shrink) {
    return hull.compute(&corners[0].m_floats[0], sizeof(btVector3), count, shrink, kShrinkClamp);
  };
  btConvexHullComputer unshrunk;
  compute(unshrunk, 0.0);

  auto shape = std::make_unique<btConvexHullShape>();
  // No initializePolyhedralFeatures: on shrunk hulls contact would begin two margins too late.
  for (double shrink_m = kMargin_m; shrink_m >= kLeastMargin_m; shrink_m *= 0.5) {
    btConvexHullComputer hull;
    const double margin = compute(hull, kLengthScale * shrink_m);  // negative: no core would remain
    if (margin <= 0.0 || hull.vertices.size() < 4) continue;
    if (corner_loss(unshrunk, hull, margin) > kLengthScale * kMaxCornerLoss_m) continue;
    for (int i = 0; i < hull.vertices.size(); ++i) shape->addPoint(hull.vertices[i], false);
    shape->recalcLocalAabb();
    shape->setMargin(margin);
    return shape;
  }
  for (const btVector3& c : corners) shape->addPoint(c, false);
  shape->recalcLocalAabb();
  shape->setMargin(kLengthScale * kLeastMargin_m);
  return shape;
}

/// Gives the last child its contact points for half spaces.
void touch_planes_by(BulletShape& shape, PlanePoints points) {
  shape.plane_points.push_back(std::make_unique<PlanePoints>(std::move(points)));
  shape.children.back()->setUserPointer(shape.plane_points.back().get());
}

}  // namespace

BulletShape make_bullet_shape(const RigidBody& body) {
  BulletShape result;
  if (const auto* sphere = std::get_if<SphereShape>(&body.shape)) {
    result.children.push_back(std::make_unique<btSphereShape>(kLengthScale * sphere->radius));
    touch_planes_by(result, {{btVector3(0, 0, 0)}, kLengthScale * sphere->radius});
  } else if (const auto* box = std::get_if<BoxShape>(&body.shape)) {
    const Vec3& h = box->half_size;
    auto shape = std::make_unique<btBoxShape>(scaled(h));
    shape->setMargin(kLengthScale * std::min(kMargin_m, kShrinkClamp * h.minCoeff()));  // the outer size stays
    result.children.push_back(std::move(shape));
    PlanePoints corners;
    for (int k = 0; k < 8; ++k) {
      const Vec3 signs(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
      corners.points.push_back(scaled(signs.cwiseProduct(h)));
    }
    touch_planes_by(result, std::move(corners));
  } else if (std::holds_alternative<HalfSpaceShape>(body.shape)) {
    // A plane, not a large box: its depth is defined everywhere, so no body can leave at the bottom.
    result.children.push_back(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), 0.0));
  } else {
    const auto& parts = std::get<ConvexShape>(body.shape).parts;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      result.children.push_back(make_hull(body, parts[i], i));
      PlanePoints corners;
      for (const Vec3& p : parts[i]) corners.points.push_back(scaled(p));
      touch_planes_by(result, std::move(corners));
    }
    if (parts.size() > 1) {
      auto compound = std::make_unique<btCompoundShape>();
      for (const auto& child : result.children) compound->addChildShape(btTransform::getIdentity(), child.get());
      result.compound = std::move(compound);
    }
  }
  return result;
}

}  // namespace sunder::rigid
