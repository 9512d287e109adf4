#pragma once
// A Bullet world whose step is taken apart: detect / solve / relax; the caller moves the bodies.
// Private to the adapter. Lengths, masses and velocities here are Bullet's (bullet_shapes.h).
#include <BulletCollision/CollisionDispatch/btConvexConvexAlgorithm.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "coupler/core/body.h"
#include "rigid/engine/bullet_plane.h"

namespace sunder::rigid {

/// What the world reads of a body, kept in Bullet's user indices.
struct BodyTag {
  static void set(btRigidBody& body, int slot, std::uint32_t contact_group);
  static int slot(const btCollisionObject& body) { return body.getUserIndex(); }
  static std::uint32_t group(const btCollisionObject& body) { return static_cast<std::uint32_t>(body.getUserIndex2()); }
};

class BulletWorld {
 public:
  BulletWorld();
  ~BulletWorld();

  /// The body outlives the world.
  void add(btRigidBody& body, std::uint32_t contact_group);
  void set_contact_laws(const std::vector<ContactLaw>& laws);

  /// Finds contacts at the present poses; false where there are none to solve.
  bool detect(double window_s);
  /// Solves velocities, and moves poses out of penetration (split impulses).
  void solve(double window_s);
  /// Velocity-only solve at the present poses of the contacts that acted in solve() or touch now;
  /// gives contacts that met fast enough their restitution.
  void relax(double window_s);

 private:
  using Pair = std::pair<std::uint64_t, std::uint64_t>;  // lower first
  struct Row {
    btManifoldPoint* point;
    const btCollisionObject *first, *second;
    double approach;     // closing speed before solve()
    double restitution;  // [-]
    double allowance;    // penetration that does not count
    bool acted;          // pushed in solve()
  };
  class World;

  static int island(const Row& row);

  const ContactLaw& law(const btCollisionObject& a, const btCollisionObject& b) const;
  /// Pairs that overlap when one of the two is new (shards share faces with their neighbours) may keep
  /// that overlap: it is subtracted until they come apart, and never grows again.
  void update_allowances();

  btDefaultCollisionConfiguration configuration_;
  PlaneCreateFunc shape_on_plane_{false}, plane_under_shape_{true};
  btGjkEpaPenetrationDepthSolver depth_solver_;
  btConvexConvexAlgorithm::CreateFunc one_point_{&depth_solver_};
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  std::unique_ptr<World> world_;
  std::map<Pair, ContactLaw> laws_;
  ContactLaw other_pairs_;  // friction 0.5, restitution 0
  std::vector<Row> rows_;
  std::map<Pair, double> allowances_;
  int first_newborn_slot_ = 0;  // bodies from here on have not been through detect()
  int next_slot_ = 0;
};

}  // namespace sunder::rigid
