#pragma once
// A Bullet world whose step is taken apart: detect / solve / relax; the caller moves the bodies.
// Private to the adapter. Lengths, masses and velocities here are Bullet's (bullet_shapes.h).
#include <BulletCollision/CollisionDispatch/btConvexConvexAlgorithm.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "coupler/core/body.h"
#include "rigid/engine/bullet_boxes.h"
#include "rigid/engine/bullet_joints.h"
#include "rigid/engine/bullet_plane.h"
#include "rigid/engine/bullet_tag.h"

namespace sunder::rigid {

using BodyPair = std::pair<BodyId, BodyId>;  // lower first

/// What a world keeps from window to window besides the bodies' motions.
struct WorldMemory {
  std::map<BodyId, bool> newborn;         // every body
  std::map<BodyPair, double> allowances;  // overlap that a pair may keep from birth [Bullet lengths], above 0
  BulletJoints::Impulses joints;          // of every joint: what its solves start from
};

/// A contact as see() found it.
struct SeenContact {
  const btManifoldPoint* point;  // until the next see()
  BodyPair bodies;               // the point's A and B, in this order
  ContactLaw law;
  double depth;  // of the pair [Bullet lengths], 0 where its deepest point is none
};

class BulletWorld {
 public:
  enum class Use { kMove, kLook };  // detect, solve, relax; or see
  explicit BulletWorld(Use use);
  ~BulletWorld();

  /// The body outlives the world.
  void add(btRigidBody& body, BodyId id, std::uint32_t contact_group);
  void set_contact_laws(const std::vector<ContactLaw>& laws);
  /// Both bodies are here; they collide no more. Use::kLook heeds only that.
  void add_joint(const Joint& joint);
  void release_joint(std::uint32_t id) { joints_.release(id); }
  bool has_joint(std::uint32_t id) const { return joints_.has(id); }

  /// Finds contacts at the present poses; false where there are none to solve. Contacts of bodies in `solved` count
  /// for what overlap may be kept, but are not solved.
  bool detect(double window_s, const std::set<BodyId>& solved);
  /// Before solve(): joints that hold no body of `solved` act. False where there is none.
  bool choose_joints(const std::set<BodyId>& solved) { return joints_.choose(solved); }
  /// Whether one that acts holds the body.
  bool holds(BodyId id) const { return joints_.hold(id); }
  /// How joints look ahead: where a body would end with its present velocity [Bullet lengths], and what puts velocities
  /// and poses back as they were before solve().
  struct Ahead {
    std::function<btTransform(BodyId)> end_of;
    std::function<void()> put_back;
  };
  /// Solves velocities, and moves poses out of penetration (split impulses).
  void solve(double window_s, const Ahead& ahead);
  /// Velocity-only solve at the present poses of the contacts that acted in solve() or touch now;
  /// gives contacts that met fast enough their restitution.
  void relax(double window_s);

  /// Use::kLook. Contacts of the listed bodies at the present poses. They are kept from call to call
  /// as detect() keeps them, so that flat faces have their four points.
  std::vector<SeenContact> see(double window_s, const std::set<BodyId>& listed);
  /// Overlap that the next detect() would let the pair keep; `depth` [Bullet lengths] is what it would find. Bodies
  /// that are not here yet count as newborn.
  double allowance(const BodyPair& pair, double depth) const;

  WorldMemory memory() const;
  /// As a world that was made just now, given its bodies by ascending id where they are, and this memory: whatever
  /// came before, the windows from here on are the same to the bit.
  void start_over(const WorldMemory& memory);
  /// Takes all bodies out.
  void clear();

 private:
  struct Row {
    btManifoldPoint* point;
    const btCollisionObject *first, *second;
    double approach;     // closing speed before solve()
    double restitution;  // [-]
    double allowance;    // penetration that does not count
    bool acted;          // pushed in solve()
    bool left_out;       // of a body whose contacts are solved elsewhere
  };
  class World;

  static int island(const Row& row);

  const ContactLaw& law(const btCollisionObject& a, const btCollisionObject& b) const;
  /// Pairs that overlap when one of the two is new (shards share faces with their neighbours) may keep
  /// that overlap: it is subtracted until they come apart, and never grows again.
  void update_allowances();
  /// The solve of relax() where joints act; `mode` is that of solve().
  void relax_joined(double window_s, int mode);
  bool contacts_to_solve() const;
  bool newborn(BodyId id) const;

  btDefaultCollisionConfiguration configuration_;
  PlaneCreateFunc shape_on_plane_{false}, plane_under_shape_{true};
  BoxesCreateFunc boxes_;
  btGjkEpaPenetrationDepthSolver depth_solver_;
  btConvexConvexAlgorithm::CreateFunc one_point_{&depth_solver_};
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  std::unique_ptr<World> world_;
  btRigidBody world_body_{0.0, nullptr, nullptr};  // what joints to the world hold on to
  BulletJoints joints_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, ContactLaw> laws_;  // lower group first
  ContactLaw other_pairs_;                                              // friction 0.5, restitution 0
  std::vector<Row> rows_;
  std::map<BodyPair, double> allowances_;
  std::map<BodyId, btRigidBody*> bodies_;
};

}  // namespace sunder::rigid
