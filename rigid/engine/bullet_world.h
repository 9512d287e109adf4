#pragma once
// A Bullet world with its step in separate parts: detect, solve, relax. The caller moves the bodies. Private to the
// adapter. Units are Bullet's (bullet_shapes.h).
#include <BulletCollision/CollisionDispatch/btConvexConvexAlgorithm.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "coupler/core/body.h"
#include "rigid/engine/bullet_boxes.h"
#include "rigid/engine/bullet_joints.h"
#include "rigid/engine/bullet_plane.h"
#include "rigid/engine/bullet_tag.h"
#include "rigid/engine/rebound.h"

namespace sunder::rigid {

using BodyPair = std::pair<BodyId, BodyId>;  // lower first

/// State of a world that lasts from window to window, besides the bodies' motions.
struct WorldMemory {
  std::map<BodyId, bool> newborn;         // of every body
  std::map<BodyPair, double> allowances;  // overlap that a pair keeps from birth [Bullet lengths], above 0
  BulletJoints::Impulses joints;          // of every joint: its solves start from them
};

/// A contact found by see().
struct SeenContact {
  const btManifoldPoint* point;  // valid until the next see()
  BodyPair bodies;               // the point's A and B, in this order
  ContactLaw law;
  double depth;  // largest overlap of the pair [Bullet lengths]; 0 where there is none
};

/// Finds and solves the contacts and joints of a window.
class BulletWorld {
 public:
  enum class Use { kMove, kLook };  // kMove: detect, solve, relax; kLook: see
  explicit BulletWorld(Use use);
  ~BulletWorld();

  /// Adds a body, which outlives the world.
  void add(btRigidBody& body, BodyId id, std::uint32_t contact_group);
  /// Replaces all contact laws.
  void set_contact_laws(const std::vector<ContactLaw>& laws);
  /// Adds a joint between bodies of this world, which do not collide from here on. With Use::kLook this is its only
  /// effect.
  void add_joint(const Joint& joint);
  void release_joint(std::uint32_t id) { joints_.release(id); }
  bool has_joint(std::uint32_t id) const { return joints_.has(id); }

  /// Finds contacts at the present poses; false where there is none to solve. Contacts of bodies in `solved` are not
  /// solved, but they count for overlaps from birth.
  bool detect(double window_s, const std::set<BodyId>& solved);
  /// Before solve(): selects the joints without a body of `solved`. False where there is none.
  bool choose_joints(const std::set<BodyId>& solved) { return joints_.choose(solved); }
  /// True where an acting joint holds the body.
  bool holds(BodyId id) const { return joints_.hold(id); }
  /// The caller's part in solving joints: the pose at which a body would end with its present velocity [Bullet
  /// lengths], and a function that resets velocities and poses to those before solve().
  struct Ahead {
    std::function<btTransform(BodyId)> end_of;
    std::function<void()> put_back;
  };
  /// Solves velocities, and moves poses out of penetration without changing velocities (split impulses).
  void solve(double window_s, const Ahead& ahead);
  /// A body that leaves its touch within the window, and what it has touched.
  struct Bounce {
    BodyId partner = 0;
    double touch = 0.0;  // since the window's start [s]
  };
  /// Solves velocities at the present poses, for contacts that acted in solve() or touch now. Applies restitution to
  /// contacts that closed fast enough. `pull`: a body's acceleration without them [Bullet lengths/s^2]. Returns the
  /// moving bodies whose rebound is sound (rebound.h).
  std::map<BodyId, Bounce> relax(double window_s, const std::function<btVector3(BodyId)>& pull);
  /// After relax(): solves the contacts of two moving bodies anew that acted in solve(). The caller has put both at
  /// their touch, with the motions in which they reach it, whose closing speed restitution goes by. Changes their
  /// velocities only.
  void bounce_apart(double window_s, BodyId first, BodyId second);
  /// Overlap that two bodies keep from birth [Bullet lengths].
  double overlap_kept(BodyId first, BodyId second) const;

  /// Use::kLook. Contacts of the listed bodies at the present poses. Bullet keeps points between calls, so that flat
  /// faces have four.
  std::vector<SeenContact> see(double window_s, const std::set<BodyId>& listed);
  /// Overlap that the pair may keep in the next detect() [Bullet lengths], if that finds an overlap of `depth`. Bodies
  /// that are not in this world yet count as newborn.
  double allowance(const BodyPair& pair, double depth) const;

  /// State for save().
  WorldMemory memory() const;
  /// Resets the world to a saved state. From here on its windows are the same, to the bit, as those of a new world with
  /// the same bodies at the same poses, whatever came before.
  void start_over(const WorldMemory& memory);
  /// Removes all bodies and joints.
  void clear();

 private:
  struct Row {
    btPersistentManifold* manifold;
    btManifoldPoint* point;
    const btCollisionObject *first, *second;
    double approach;     // closing speed before solve() [cm/s]
    double restitution;  // [-]
    double allowance;    // overlap that is not pushed apart [cm]
    double gap;          // before solve() [cm]
    bool acted;          // had an impulse in solve()
    bool left_out;       // the shell process has solved it
  };
  class World;
  class PointMemory;

  static int island(const Row& row);

  const ContactLaw& law(const btCollisionObject& a, const btCollisionObject& b) const;
  /// A pair that overlaps when one of the two bodies is newborn may keep this overlap, because shards share faces with
  /// their neighbours. It is subtracted until they separate, and it never grows.
  void update_allowances();
  /// The rebounds of relax(), by row.
  std::vector<std::optional<Rebound>> find_rebounds(double window_s,
                                                    const std::function<btVector3(BodyId)>& pull) const;
  /// The solve of relax() with joints; `mode`: Bullet's solver mode in solve().
  void relax_joined(double window_s, int mode);
  bool contacts_to_solve() const;
  bool newborn(BodyId id) const;

  btDefaultCollisionConfiguration configuration_;
  PlaneCreateFunc shape_on_plane_{false}, plane_under_shape_{true};
  BoxesCreateFunc boxes_;
  btGjkEpaPenetrationDepthSolver depth_solver_;
  HullsCreateFunc hulls_{&depth_solver_};
  btConvexConvexAlgorithm::CreateFunc one_point_{&depth_solver_};
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  std::unique_ptr<World> world_;
  btRigidBody world_body_{0.0, nullptr, nullptr};  // the static end of joints to the world
  BulletJoints joints_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, ContactLaw> laws_;  // lower group first
  ContactLaw other_pairs_;                                              // friction 0.5, restitution 0
  std::vector<Row> rows_;
  std::map<BodyPair, std::vector<Row>> of_pairs_;  // rows, for bounce_apart(); empty: not asked for yet in this window
  std::map<BodyPair, double> allowances_;
  std::map<BodyId, btRigidBody*> bodies_;
};

}  // namespace sunder::rigid
