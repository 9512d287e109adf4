#include "rigid/engine/bullet_world.h"

#include <algorithm>

#include "rigid/engine/bullet_shapes.h"

// A global of Bullet without a declaration in its headers.
extern btScalar gContactBreakingThreshold;

namespace sunder::rigid {
namespace {

/// Contacts of bodies at rest are kept up to this gap; less stacks worse, more keeps stale points.
constexpr double kContactGap_m = 2e-3;
/// Meeting slower than this is no impact and does not bounce: resting closes with g H per window.
constexpr double kImpactSpeed_m_s = 0.05;
constexpr int kIterations = 60;  // twenty thin plates creep sideways by 0.30, 0.26, 0.21 mm in 2 s with 40, 50, 80
/// Share of a penetration taken back per window by moving poses, never by velocities.
constexpr double kPositionShare = 0.2;  // [-]
/// Joints are solved until none is farther off than this, and where there are contacts as well, until the joints have
/// no more to change than that. [m/s or rad/s]
constexpr double kJointResidual = 1e-9, kContactResidual = 1e-5;
constexpr int kMostTurns = 8, kMostPasses = 4;
/// Bullet leaves out points farther apart than this; how relax() drops a row.
constexpr double kProcessed = 1e6, kLeftOut = 1e7;  // [Bullet lengths]

std::pair<std::uint32_t, std::uint32_t> ordered(std::uint32_t a, std::uint32_t b) {
  return {std::min(a, b), std::max(a, b)};
}

btDefaultCollisionConstructionInfo pool_sizes() {
  btDefaultCollisionConstructionInfo info;
  info.m_customCollisionAlgorithmMaxElementSize =
      std::max(PlaneCreateFunc::algorithm_size(), BoxesCreateFunc::algorithm_size());
  return info;
}

btVector3 velocity_at(const btCollisionObject& object, const btVector3& world_point) {
  const btRigidBody* body = btRigidBody::upcast(&object);
  return body->getVelocityInLocalPoint(world_point - body->getCenterOfMassPosition());
}

/// Bullet pushes either body at its own point of a contact. What is foreseen or overlaps has these apart, and friction,
/// or a normal that no longer leads from one to the other, would then turn the pair out of nothing.
void act_at_one_point(btManifoldPoint& point) {
  point.m_positionWorldOnA = point.m_positionWorldOnB = 0.5 * (point.m_positionWorldOnA + point.m_positionWorldOnB);
}

/// How far off contacts of two bodies are found: as far as they can come in the window, or a fast shard is first seen
/// when most of it is behind a thin plate, and pushed out there. A plane looks ahead by itself, from point to point.
double foreseen(const btCollisionObject& a, const btCollisionObject& b, double h) {
  const auto is_plane = [](const btCollisionObject& o) {
    return o.getCollisionShape()->getShapeType() == STATIC_PLANE_PROXYTYPE;
  };
  const double gap = kLengthScale * kContactGap_m;
  if (is_plane(a) || is_plane(b)) return gap;
  const btVector3 apart = btRigidBody::upcast(&a)->getLinearVelocity() - btRigidBody::upcast(&b)->getLinearVelocity();
  return gap + h * apart.length();
}

/// Bullet gives what it makes here, manifolds of compounds' parts too, the distance that its global has.
void find_all(btBroadphasePair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& how) {
  const auto object = [](const btBroadphaseProxy* proxy) -> const btCollisionObject& {
    return *static_cast<const btCollisionObject*>(proxy->m_clientObject);
  };
  gContactBreakingThreshold = foreseen(object(pair.m_pProxy0), object(pair.m_pProxy1), how.m_timeStep);
  btCollisionDispatcher::defaultNearCallback(pair, dispatcher, how);
}

/// Contacts of the listed bodies only.
void find_listed(btBroadphasePair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& how) {
  const auto listed = [](const btBroadphaseProxy* proxy) {
    return BodyTag::listed(*static_cast<const btCollisionObject*>(proxy->m_clientObject));
  };
  if (listed(pair.m_pProxy0) || listed(pair.m_pProxy1)) find_all(pair, dispatcher, how);
}

}  // namespace

int BulletWorld::island(const Row& row) {
  return std::max(row.first->getIslandTag(), row.second->getIslandTag());  // a static body has -1
}

class BulletWorld::World final : public btDiscreteDynamicsWorld {
 public:
  using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;

  // No predict: without damping and forces it would only fill the pose for continuous collision.
  void find(double h) {
    getDispatchInfo().m_timeStep = h;
    getDispatchInfo().m_stepCount = 0;
    for (int i = 0; i < m_dispatcher1->getNumManifolds(); ++i) {
      btPersistentManifold& manifold = *m_dispatcher1->getManifoldByIndexInternal(i);
      manifold.setContactBreakingThreshold(foreseen(*manifold.getBody0(), *manifold.getBody1(), h));
    }
    performDiscreteCollisionDetection();
    gContactBreakingThreshold = kLengthScale * kContactGap_m;
  }
  void updateAabbs() override {
    const double h = getDispatchInfo().m_timeStep;
    for (int i = 0; i < m_collisionObjects.size(); ++i) {
      btCollisionObject& object = *m_collisionObjects[i];
      const btRigidBody* body = btRigidBody::upcast(&object);
      gContactBreakingThreshold = kLengthScale * kContactGap_m + h * body->getLinearVelocity().length();
      updateSingleAabb(&object);
    }
  }
  // Islands anew for every solution: walking over them destroys them, and contacts of islands that are no more would
  // silently be left out the next time.
  void solve(double h) {
    calculateSimulationIslands();
    getSolverInfo().m_timeStep = h;
    solveConstraints(getSolverInfo());
  }
};

BulletWorld::BulletWorld(Use use) : configuration_(pool_sizes()), dispatcher_(&configuration_) {
  configuration_.setConvexConvexMultipointIterations(3, 3);  // one point is too few for plate on plate
  for (int shape : {SPHERE_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE, CONVEX_HULL_SHAPE_PROXYTYPE}) {
    dispatcher_.registerCollisionCreateFunc(shape, STATIC_PLANE_PROXYTYPE, &shape_on_plane_);
    dispatcher_.registerCollisionCreateFunc(STATIC_PLANE_PROXYTYPE, shape, &plane_under_shape_);
  }
  // The further points come from turning a body a little and back: on a sphere they are no contacts, a
  // ball on a plate sinks in by them and rolls off.
  for (int shape : {BOX_SHAPE_PROXYTYPE, CONVEX_HULL_SHAPE_PROXYTYPE}) {
    dispatcher_.registerCollisionCreateFunc(SPHERE_SHAPE_PROXYTYPE, shape, &one_point_);
    dispatcher_.registerCollisionCreateFunc(shape, SPHERE_SHAPE_PROXYTYPE, &one_point_);
  }
  dispatcher_.registerCollisionCreateFunc(BOX_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE, &boxes_);
  world_body_.setUserIndex(0);  // no body's id
  dispatcher_.setNearCallback(find_all);
  if (use == Use::kLook) {
    dispatcher_.setNearCallback(find_listed);
    // Bullet's own for two spheres finds them only once they overlap.
    dispatcher_.registerCollisionCreateFunc(SPHERE_SHAPE_PROXYTYPE, SPHERE_SHAPE_PROXYTYPE, &one_point_);
  }
  gContactBreakingThreshold = kLengthScale * kContactGap_m;  // process-wide; every instance sets the same
  // Else the gap would be a share of each body's size.
  dispatcher_.setDispatcherFlags(dispatcher_.getDispatcherFlags() &
                                 ~btCollisionDispatcher::CD_USE_RELATIVE_CONTACT_BREAKING_THRESHOLD);
  world_ = std::make_unique<World>(&dispatcher_, &broadphase_, &solver_, &configuration_);
  world_->setGravity(btVector3(0, 0, 0));  // the handbacks carry gravity
  world_->getDispatchInfo().m_useContinuous = false;
  btContactSolverInfo& info = world_->getSolverInfo();
  info.m_numIterations = kIterations;
  info.m_erp2 = kPositionShare;
  info.m_warmstartingFactor = 1.0;  // with Bullet's 0.85 a stack never carries all of its weight, and sinks
  info.m_splitImpulsePenetrationThreshold = 0.0;  // Bullet's -0.04 turns shallow penetration into velocity
  // Two directions, the first along the slip: one alone leaves the other free.
  info.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
}

BulletWorld::~BulletWorld() = default;

void BulletWorld::add(btRigidBody& body, BodyId id, std::uint32_t contact_group) {
  BodyTag::set(body, id, contact_group);
  BodyTag::set_newborn(body, true);
  body.setDamping(0, 0);
  body.setSleepingThresholds(0, 0);
  body.setActivationState(DISABLE_DEACTIVATION);
  body.setFlags(BT_DISABLE_WORLD_GRAVITY);  // and no gyroscopic flag: the handback turned the body already
  body.setGravity(btVector3(0, 0, 0));
  body.setCcdMotionThreshold(0);
  body.setContactProcessingThreshold(kProcessed);
  world_->addRigidBody(&body);
  bodies_[id] = &body;
}

void BulletWorld::set_contact_laws(const std::vector<ContactLaw>& laws) {
  laws_.clear();
  for (const ContactLaw& law : laws) laws_[ordered(law.first_group, law.second_group)] = law;
}

const ContactLaw& BulletWorld::law(const btCollisionObject& a, const btCollisionObject& b) const {
  const auto found = laws_.find(ordered(BodyTag::group(a), BodyTag::group(b)));
  return found == laws_.end() ? other_pairs_ : found->second;
}

bool BulletWorld::detect(double window_s, const std::set<BodyId>& solved) {
  world_->find(window_s);
  rows_.clear();
  for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
    btPersistentManifold& manifold = *dispatcher_.getManifoldByIndexInternal(i);
    const btCollisionObject &a = *manifold.getBody0(), &b = *manifold.getBody1();
    const ContactLaw& pair_law = law(a, b);
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      btManifoldPoint& point = manifold.getContactPoint(k);
      // Set here instead of through Bullet's callbacks, which are process-wide.
      point.m_combinedFriction = pair_law.friction;
      point.m_combinedRestitution = 0.0;  // relax() gives it, see there
      act_at_one_point(point);
      const btVector3 closing =
          velocity_at(b, point.getPositionWorldOnB()) - velocity_at(a, point.getPositionWorldOnA());
      rows_.push_back({&point, &a, &b, closing.dot(point.m_normalWorldOnB), pair_law.restitution, 0.0, false, false});
    }
  }
  update_allowances();
  if (solved.empty()) return !rows_.empty();
  bool any = false;
  for (Row& row : rows_) {
    row.left_out = solved.count(BodyTag::id(*row.first)) > 0 || solved.count(BodyTag::id(*row.second)) > 0;
    any = any || !row.left_out;
    if (!row.left_out) continue;
    btManifoldPoint& point = *row.point;
    point.setDistance(kLeftOut);
    // what it pushed with when it was last solved here is no start for the next time
    point.m_appliedImpulse = point.m_appliedImpulseLateral1 = point.m_appliedImpulseLateral2 = 0.0;
  }
  return any;
}

std::vector<SeenContact> BulletWorld::see(double window_s, const std::set<BodyId>& listed) {
  for (const auto& [id, body] : bodies_) BodyTag::set_listed(*body, listed.count(id) > 0);
  world_->find(window_s);
  std::vector<SeenContact> seen;
  std::map<BodyPair, double> depths;
  for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *dispatcher_.getManifoldByIndexInternal(i);
    const btCollisionObject &a = *manifold.getBody0(), &b = *manifold.getBody1();
    if (!BodyTag::listed(a) && !BodyTag::listed(b)) continue;
    const BodyPair bodies(BodyTag::id(a), BodyTag::id(b));
    double& depth = depths[ordered(bodies.first, bodies.second)];
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& point = manifold.getContactPoint(k);
      depth = std::max(depth, -point.getDistance());
      seen.push_back({&point, bodies, law(a, b), 0.0});
    }
  }
  for (SeenContact& contact : seen) contact.depth = depths.at(ordered(contact.bodies.first, contact.bodies.second));
  return seen;
}

bool BulletWorld::newborn(BodyId id) const {
  const auto found = bodies_.find(id);
  return found == bodies_.end() || BodyTag::newborn(*found->second);
}

double BulletWorld::allowance(const BodyPair& pair, double depth) const {
  const auto known = allowances_.find(ordered(pair.first, pair.second));
  if (known != allowances_.end()) return std::min(depth, known->second);
  return newborn(pair.first) || newborn(pair.second) ? depth : 0.0;
}

void BulletWorld::update_allowances() {
  // Depth of each pair that has an allowance or a newborn body.
  std::map<BodyPair, double> depths;
  for (const Row& row : rows_) {
    const BodyPair pair = ordered(BodyTag::id(*row.first), BodyTag::id(*row.second));
    if (!BodyTag::newborn(*row.first) && !BodyTag::newborn(*row.second) && !allowances_.count(pair)) continue;
    double& depth = depths[pair];  // 0 where new
    depth = std::max(depth, -row.point->getDistance());
  }
  std::map<BodyPair, double> next;
  for (const auto& [pair, depth] : depths) {
    const double kept = allowance(pair, depth);
    if (kept > 0.0) next[pair] = kept;  // a pair that has come apart is as any other
  }
  allowances_ = std::move(next);
  for (const auto& [id, body] : bodies_) BodyTag::set_newborn(*body, false);
  if (allowances_.empty()) return;
  for (Row& row : rows_) {
    const auto found = allowances_.find(ordered(BodyTag::id(*row.first), BodyTag::id(*row.second)));
    if (found == allowances_.end()) continue;
    row.allowance = found->second;
    row.point->setDistance(row.point->getDistance() + row.allowance);
  }
}

void BulletWorld::add_joint(const Joint& joint) {
  btRigidBody &first = *bodies_.at(joint.first), &second = joint.second == 0 ? world_body_ : *bodies_.at(joint.second);
  // contacts that there are already would go on to be solved
  broadphase_.getOverlappingPairCache()->cleanProxyFromPairs(first.getBroadphaseHandle(), &dispatcher_);
  auto made = std::make_unique<BulletJoint>(joint, first, second);
  world_->addConstraint(made.get(), &second != &world_body_);
  joints_.add(joint.id, std::move(made));
}

bool BulletWorld::contacts_to_solve() const {
  return std::any_of(rows_.begin(), rows_.end(), [](const Row& row) { return !row.left_out; });
}

void BulletWorld::solve(double window_s, const Ahead& ahead) {
  if (!joints_.any()) return world_->solve(window_s);
  joints_.begin(BulletJoint::kSolve, window_s);
  const bool contacts = contacts_to_solve();
  for (int pass = 1;; ++pass) {
    joints_.push();
    if (contacts) {
      world_->solve(window_s);
      joints_.take_in(window_s);
    }
    double moved = 0.0;
    for (int turn = 0; turn < kMostTurns; ++turn) {
      moved += joints_.correct();
      if (joints_.mend(window_s, ahead.end_of) <= kJointResidual) break;
    }
    if (!contacts || moved <= kContactResidual || pass == kMostPasses) return;
    ahead.put_back();
  }
}

void BulletWorld::relax_joined(double window_s, int mode) {
  struct Velocity {
    btRigidBody* body;
    btVector3 linear, angular;
  };
  std::vector<Velocity> start;
  for (const auto& [id, body] : bodies_)
    if (!body->isStaticObject()) start.push_back({body, body->getLinearVelocity(), body->getAngularVelocity()});
  joints_.begin(BulletJoint::kRelax, window_s);
  const bool contacts = contacts_to_solve();
  for (int pass = 1;; ++pass) {
    joints_.push();
    if (contacts) {
      world_->solve(window_s);
      joints_.take_in(window_s);
    }
    const double moved = joints_.correct();
    if (!contacts || moved <= kContactResidual || pass == kMostPasses) return;
    for (const Velocity& v : start) v.body->setLinearVelocity(v.linear), v.body->setAngularVelocity(v.angular);
    world_->getSolverInfo().m_solverMode = mode;  // from the contact impulses of the last pass, as joints do
  }
}

void BulletWorld::relax(double window_s) {
  // Restitution is given here and not in solve(): there a foreseen contact (gap > 0) has to close its
  // gap in the window, and Bullet would take that closing off the rebound.
  struct Kept {
    double impulse, lateral_1, lateral_2;
  };
  std::vector<Kept> kept;
  kept.reserve(rows_.size());
  for (Row& row : rows_) {
    btManifoldPoint& point = *row.point;
    kept.push_back({point.m_appliedImpulse, point.m_appliedImpulseLateral1, point.m_appliedImpulseLateral2});
    point.m_positionWorldOnA = row.first->getWorldTransform() * point.m_localPointA;
    point.m_positionWorldOnB = row.second->getWorldTransform() * point.m_localPointB;
    const double gap =
        (point.m_positionWorldOnA - point.m_positionWorldOnB).dot(point.m_normalWorldOnB) + row.allowance;
    act_at_one_point(point);
    if (row.left_out) continue;
    row.acted = point.m_appliedImpulse > 0.0;
    point.setDistance(row.acted || gap <= 0.0 ? 0.0 : kLeftOut);
    if (row.acted && row.restitution > 0.0 && row.approach > kLengthScale * kImpactSpeed_m_s) {
      // Bullet aims at the velocity -distance * erp / H
      point.setDistance(-row.restitution * row.approach * window_s);
      point.m_contactPointFlags |= BT_CONTACT_FLAG_HAS_CONTACT_ERP;
      point.m_contactERP = 1.0;
    }
  }
  btContactSolverInfo& info = world_->getSolverInfo();
  const int mode = info.m_solverMode;
  info.m_solverMode &= ~SOLVER_USE_WARMSTARTING;  // the impulses of solve() are in the velocities already
  info.m_splitImpulse = false;                    // poses stay
  if (joints_.any())
    relax_joined(window_s, mode);
  else
    world_->solve(window_s);
  info.m_solverMode = mode;
  info.m_splitImpulse = true;
  // solve() of the next window starts from its own impulses, but not where there was an impact: with a
  // heavy body on a light one the iterations would not take back all of it, and it would push.
  std::set<int> struck_islands;
  for (const Row& row : rows_)
    if (row.approach > kLengthScale * kImpactSpeed_m_s && row.acted) struck_islands.insert(island(row));
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    btManifoldPoint& point = *rows_[i].point;
    point.m_appliedImpulse = struck_islands.count(island(rows_[i])) ? 0.0 : kept[i].impulse;
    point.m_appliedImpulseLateral1 = kept[i].lateral_1;
    point.m_appliedImpulseLateral2 = kept[i].lateral_2;
    point.m_contactPointFlags &= ~BT_CONTACT_FLAG_HAS_CONTACT_ERP;
    point.m_contactERP = 0.0;
  }
}

WorldMemory BulletWorld::memory() const {
  WorldMemory memory;
  for (const auto& [id, body] : bodies_) memory.newborn[id] = BodyTag::newborn(*body);
  memory.allowances = allowances_;
  memory.joints = joints_.impulses();
  return memory;
}

void BulletWorld::clear() {
  // All of them, static ones too: resetPool does nothing while one is left, and the order of pairs, which decides in
  // which order contacts are solved, hangs on the history of the broadphase.
  for (const auto& [id, joint] : joints_.all()) world_->removeConstraint(joint.get());
  joints_.take_out();
  for (const auto& [id, body] : bodies_) world_->removeRigidBody(body);
  bodies_.clear();
  broadphase_.resetPool(&dispatcher_);
  solver_.reset();
  rows_.clear();
  allowances_.clear();
}

void BulletWorld::start_over(const WorldMemory& memory) {
  const std::map<BodyId, btRigidBody*> bodies = bodies_;
  for (const auto& [id, joint] : joints_.all()) world_->removeConstraint(joint.get());
  auto joints = joints_.take_out();
  clear();
  for (const auto& [id, body] : bodies) {
    world_->addRigidBody(body);
    BodyTag::set_newborn(*body, memory.newborn.at(id));
  }
  bodies_ = bodies;
  allowances_ = memory.allowances;
  for (auto& [id, joint] : joints) {  // by id too, whenever they were added: their order in the solver counts
    world_->addConstraint(joint.get(), &joint->getRigidBodyB() != &world_body_);
    joint->set_impulses(memory.joints.at(id));
    joints_.add(id, std::move(joint));
  }
}

}  // namespace sunder::rigid
