#include "rigid/engine/bullet_world.h"

#include <algorithm>
#include <array>

#include "rigid/engine/bullet_points.h"
#include "rigid/engine/bullet_shapes.h"
#include "rigid/engine/checks.h"

// A global of Bullet without a declaration in its headers.
extern btScalar gContactBreakingThreshold;

namespace sunder::rigid {
namespace {

/// Contacts of bodies at rest are kept up to this gap. A smaller gap makes stacks less stable, a larger one keeps
/// points that are out of date.
constexpr double kContactGap_m = 2e-3;
/// Contacts that close more slowly do not bounce: a resting body closes with g H per window.
constexpr double kImpactSpeed_m_s = 0.05;
/// Iterations of a solve. With fewer, a stack of thin plates creeps sideways more.
constexpr int kIterations = 60;
/// Share of a penetration that a window removes by moving poses. Velocities do not change.
constexpr double kPositionShare = 0.2;  // [-]
/// Joints are solved until their largest error is below the first. With contacts, passes end once joints change
/// velocities by less than the second. [m/s or rad/s]
constexpr double kJointResidual = 1e-9, kContactResidual = 1e-5;
constexpr int kMostTurns = 8, kMostPasses = 4;
/// Bullet ignores points farther apart than the first; relax() drops a row by setting its distance to the second.
constexpr double kProcessed = 1e6, kLeftOut = 1e7;  // [Bullet lengths]

btDefaultCollisionConstructionInfo pool_sizes() {
  btDefaultCollisionConstructionInfo info;
  info.m_customCollisionAlgorithmMaxElementSize = std::max(
      {PlaneCreateFunc::algorithm_size(), BoxesCreateFunc::algorithm_size(), HullsCreateFunc::algorithm_size()});
  return info;
}

/// Gap up to which contacts of two bodies are found [Bullet lengths]: the kept gap and the distance that the centres
/// move relative to each other in the window. Otherwise a fast shard would be found behind a thin plate and pushed out
/// there. The plane algorithm adds the motion of each corner itself.
double foreseen(const btCollisionObject& a, const btCollisionObject& b, double h) {
  const auto is_plane = [](const btCollisionObject& o) {
    return o.getCollisionShape()->getShapeType() == STATIC_PLANE_PROXYTYPE;
  };
  const double gap = kLengthScale * kContactGap_m;
  if (is_plane(a) || is_plane(b)) return gap;
  const btVector3 apart = btRigidBody::upcast(&a)->getLinearVelocity() - btRigidBody::upcast(&b)->getLinearVelocity();
  return gap + h * apart.length();
}

/// Finds contacts of a pair. Bullet takes the distance for new manifolds, also those of compounds' parts, from a
/// global.
void find_all(btBroadphasePair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& how) {
  const auto object = [](const btBroadphaseProxy* proxy) -> const btCollisionObject& {
    return *static_cast<const btCollisionObject*>(proxy->m_clientObject);
  };
  gContactBreakingThreshold = foreseen(object(pair.m_pProxy0), object(pair.m_pProxy1), how.m_timeStep);
  btCollisionDispatcher::defaultNearCallback(pair, dispatcher, how);
}

/// Finds contacts of pairs with a listed body.
void find_listed(btBroadphasePair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& how) {
  const auto listed = [](const btBroadphaseProxy* proxy) {
    return BodyTag::listed(*static_cast<const btCollisionObject*>(proxy->m_clientObject));
  };
  if (listed(pair.m_pProxy0) || listed(pair.m_pProxy1)) find_all(pair, dispatcher, how);
}

}  // namespace

/// Impulses of points, from which the next solve starts, kept over another one.
class BulletWorld::PointMemory {
 public:
  explicit PointMemory(const std::vector<Row>& rows) {
    kept_.reserve(rows.size());
    for (const Row& row : rows) {
      const btManifoldPoint& p = *row.point;
      kept_.push_back({p.m_appliedImpulse, p.m_appliedImpulseLateral1, p.m_appliedImpulseLateral2});
    }
  }
  /// `without`: rows whose impulse along the normal is dropped.
  template <class Without>
  void restore(std::vector<Row>& rows, Without without) const {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      btManifoldPoint& point = *rows[i].point;
      point.m_appliedImpulse = without(rows[i]) ? 0.0 : kept_[i].impulse;
      point.m_appliedImpulseLateral1 = kept_[i].lateral_1;
      point.m_appliedImpulseLateral2 = kept_[i].lateral_2;
      point.m_contactPointFlags &= ~BT_CONTACT_FLAG_HAS_CONTACT_ERP;
      point.m_contactERP = 0.0;
    }
  }

 private:
  struct Kept {
    double impulse, lateral_1, lateral_2;
  };
  std::vector<Kept> kept_;
};

int BulletWorld::island(const Row& row) {
  return std::max(row.first->getIslandTag(), row.second->getIslandTag());  // a static body has -1
}

class BulletWorld::World final : public btDiscreteDynamicsWorld {
 public:
  using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;

  // Bullet's prediction of motion is not called: it serves continuous collision only, which is off.
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
  // Islands are built for every solve, because solving destroys them. A second solve would leave out their contacts.
  void solve(double h) {
    calculateSimulationIslands();
    getSolverInfo().m_timeStep = h;
    solveConstraints(getSolverInfo());
  }
};

BulletWorld::BulletWorld(Use use) : configuration_(pool_sizes()), dispatcher_(&configuration_) {
  for (int shape : {SPHERE_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE, CONVEX_HULL_SHAPE_PROXYTYPE}) {
    dispatcher_.registerCollisionCreateFunc(shape, STATIC_PLANE_PROXYTYPE, &shape_on_plane_);
    dispatcher_.registerCollisionCreateFunc(STATIC_PLANE_PROXYTYPE, shape, &plane_under_shape_);
  }
  // Bullet finds further points by turning a body a little. On a sphere these are no contacts: a ball on a plate would
  // sink in and roll off. Bullet's own algorithm for two spheres finds them only in an overlap, a window late.
  for (int shape : {SPHERE_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE, CONVEX_HULL_SHAPE_PROXYTYPE}) {
    dispatcher_.registerCollisionCreateFunc(SPHERE_SHAPE_PROXYTYPE, shape, &one_point_);
    dispatcher_.registerCollisionCreateFunc(shape, SPHERE_SHAPE_PROXYTYPE, &one_point_);
  }
  dispatcher_.registerCollisionCreateFunc(BOX_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE, &boxes_);
  const std::array hulls_and_boxes{BOX_SHAPE_PROXYTYPE, CONVEX_HULL_SHAPE_PROXYTYPE};
  for (const int other : hulls_and_boxes) {
    dispatcher_.registerCollisionCreateFunc(CONVEX_HULL_SHAPE_PROXYTYPE, other, &hulls_);
    dispatcher_.registerCollisionCreateFunc(other, CONVEX_HULL_SHAPE_PROXYTYPE, &hulls_);
  }
  world_body_.setUserIndex(0);  // no body's id
  dispatcher_.setNearCallback(find_all);
  if (use == Use::kLook) dispatcher_.setNearCallback(find_listed);
  gContactBreakingThreshold = kLengthScale * kContactGap_m;  // process-wide; every instance sets the same value
  // Without this the gap would be a share of each body's size.
  dispatcher_.setDispatcherFlags(dispatcher_.getDispatcherFlags() &
                                 ~btCollisionDispatcher::CD_USE_RELATIVE_CONTACT_BREAKING_THRESHOLD);
  world_ = std::make_unique<World>(&dispatcher_, &broadphase_, &solver_, &configuration_);
  world_->setGravity(btVector3(0, 0, 0));  // predicted states include gravity
  world_->getDispatchInfo().m_useContinuous = false;
  btContactSolverInfo& info = world_->getSolverInfo();
  info.m_numIterations = kIterations;
  info.m_erp2 = kPositionShare;
  info.m_warmstartingFactor = 1.0;  // with Bullet's 0.85 a stack carries only part of its weight and sinks
  info.m_splitImpulsePenetrationThreshold = 0.0;  // with Bullet's -0.04 shallow penetration becomes velocity
  // Two friction directions, the first along the slip. With one, the other direction has no friction.
  info.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
}

BulletWorld::~BulletWorld() = default;

void BulletWorld::add(btRigidBody& body, BodyId id, std::uint32_t contact_group) {
  BodyTag::set(body, id, contact_group);
  BodyTag::set_newborn(body, true);
  body.setDamping(0, 0);
  body.setSleepingThresholds(0, 0);
  body.setActivationState(DISABLE_DEACTIVATION);
  body.setFlags(BT_DISABLE_WORLD_GRAVITY);  // no gyroscopic flag: the predicted state includes the turn
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
  rows_.clear(), of_pairs_.clear();
  for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
    btPersistentManifold& manifold = *dispatcher_.getManifoldByIndexInternal(i);
    const btCollisionObject &a = *manifold.getBody0(), &b = *manifold.getBody1();
    const ContactLaw& pair_law = law(a, b);
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      btManifoldPoint& point = manifold.getContactPoint(k);
      // Set here instead of through Bullet's callbacks, which are process-wide.
      point.m_combinedFriction = pair_law.friction;
      point.m_combinedRestitution = 0.0;  // relax() applies it
      act_at_one_point(point, a, b);
      const btVector3 closing =
          velocity_at(b, point.getPositionWorldOnB()) - velocity_at(a, point.getPositionWorldOnA());
      rows_.push_back({&manifold, &point, &a, &b, closing.dot(point.m_normalWorldOnB), pair_law.restitution, 0.0, 0.0,
                       false, false});
    }
  }
  update_allowances();
  for (Row& row : rows_) row.gap = row.point->getDistance();
  if (solved.empty()) return !rows_.empty();
  bool any = false;
  for (Row& row : rows_) {
    row.left_out = solved.count(BodyTag::id(*row.first)) > 0 || solved.count(BodyTag::id(*row.second)) > 0;
    any = any || !row.left_out;
    if (!row.left_out) continue;
    btManifoldPoint& point = *row.point;
    point.setDistance(kLeftOut);
    // its old impulses do not fit the next window in which it is solved here
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
    if (kept > 0.0) next[pair] = kept;  // a pair that has separated has no allowance any more
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
  // drop existing contacts of the two, which would still be solved
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
    world_->getSolverInfo().m_solverMode = mode;  // start from the contact impulses of the last pass
  }
}

std::vector<std::optional<Rebound>> BulletWorld::find_rebounds(double window_s,
                                                               const std::function<btVector3(BodyId)>& pull) const {
  std::vector<Strike> strikes;
  std::set<BodyId> apart;  // their contacts are solved elsewhere
  for (const Row& row : rows_) {
    const BodyId first = BodyTag::id(*row.first), second = BodyTag::id(*row.second);
    if (row.left_out) apart.insert(first), apart.insert(second);
    const bool bounces = row.approach > kLengthScale * kImpactSpeed_m_s;
    strikes.push_back({first, second, row.gap, row.approach,
                       (pull(first) - pull(second)).dot(row.point->m_normalWorldOnB), bounces ? row.restitution : 0.0,
                       row.point->m_appliedImpulse > 0.0 && !row.left_out});
  }
  return rebounds(
      strikes, window_s, [&](BodyId id) { return bodies_.at(id)->isStaticObject(); },
      [&](BodyId id) { return apart.count(id) > 0 || holds(id); });
}

std::map<BodyId, BulletWorld::Bounce> BulletWorld::relax(double window_s,
                                                         const std::function<btVector3(BodyId)>& pull) {
  const std::vector<std::optional<Rebound>> rebound = find_rebounds(window_s, pull);
  std::map<BodyId, Bounce> bounces;
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    if (!rebound[k]) continue;
    const Row& row = rows_[k];
    const BodyId first = BodyTag::id(*row.first), second = BodyTag::id(*row.second);
    if (!row.first->isStaticObject()) bounces[first] = {second, rebound[k]->touch};
    if (!row.second->isStaticObject()) bounces[second] = {first, rebound[k]->touch};
  }
  // Restitution is applied here and not in solve(). There a contact with a gap still closes it in the window, and
  // Bullet would subtract this closing speed from the rebound.
  const PointMemory kept(rows_);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    Row& row = rows_[k];
    btManifoldPoint& point = *row.point;
    const btVector3& normal = point.m_normalWorldOnB;
    point.m_positionWorldOnA = point_on(*row.first, point.m_localPointA, normal, 1.0);
    point.m_positionWorldOnB = point_on(*row.second, point.m_localPointB, normal, -1.0);
    const double gap =
        (point.m_positionWorldOnA - point.m_positionWorldOnB).dot(point.m_normalWorldOnB) + row.allowance;
    act_at_one_point(point, *row.first, *row.second);
    if (row.left_out) continue;
    row.acted = point.m_appliedImpulse > 0.0;
    point.setDistance(row.acted || gap <= 0.0 ? 0.0 : kLeftOut);
    if (row.acted && row.restitution > 0.0 && row.approach > kLengthScale * kImpactSpeed_m_s)
      set_target(point, rebound[k] ? rebound[k]->speed : row.restitution * row.approach, window_s);
  }
  btContactSolverInfo& info = world_->getSolverInfo();
  const int mode = info.m_solverMode;
  info.m_solverMode &= ~SOLVER_USE_WARMSTARTING;  // velocities include the impulses of solve()
  info.m_splitImpulse = false;                    // poses stay
  if (joints_.any())
    relax_joined(window_s, mode);
  else
    world_->solve(window_s);
  info.m_solverMode = mode;
  info.m_splitImpulse = true;
  // The next solve() starts from the impulses of this one, except in islands with an impact. With a heavy body on a
  // light one the iterations would not remove an impact's impulse completely.
  std::set<int> struck_islands;
  for (const Row& row : rows_)
    if (row.approach > kLengthScale * kImpactSpeed_m_s && row.acted) struck_islands.insert(island(row));
  kept.restore(rows_, [&](const Row& row) { return struck_islands.count(island(row)) > 0; });
  return bounces;
}

double BulletWorld::overlap_kept(BodyId first, BodyId second) const {
  const auto known = allowances_.find(ordered(first, second));
  return known == allowances_.end() ? 0.0 : known->second;
}

void BulletWorld::bounce_apart(double window_s, BodyId first, BodyId second) {
  if (of_pairs_.empty())
    for (const Row& row : rows_) of_pairs_[ordered(BodyTag::id(*row.first), BodyTag::id(*row.second))].push_back(row);
  std::vector<Row>& rows = of_pairs_.at(ordered(first, second));
  const PointMemory kept(rows);
  std::vector<btPersistentManifold*> manifolds;
  for (Row& row : rows) {
    if (manifolds.empty() || manifolds.back() != row.manifold) manifolds.push_back(row.manifold);
    btManifoldPoint& point = *row.point;
    point.setDistance(kLeftOut);
    if (!row.acted) continue;
    btVector3& normal = point.m_normalWorldOnB;
    if (is_ball(*row.first) && is_ball(*row.second))
      normal = (row.first->getWorldTransform().getOrigin() - row.second->getWorldTransform().getOrigin()).normalized();
    point.m_positionWorldOnA = point_on(*row.first, point.m_localPointA, normal, 1.0);
    point.m_positionWorldOnB = point_on(*row.second, point.m_localPointB, normal, -1.0);
    act_at_one_point(point, *row.first, *row.second);
    const btVector3 &here_a = point.m_positionWorldOnA, &here_b = point.m_positionWorldOnB;
    const double closing = (velocity_at(*row.second, here_b) - velocity_at(*row.first, here_a)).dot(normal);
    set_target(point, row.restitution * std::max(0.0, closing), window_s);
  }
  btCollisionObject* both[] = {bodies_.at(first), bodies_.at(second)};
  btContactSolverInfo info = world_->getSolverInfo();
  info.m_timeStep = window_s;
  info.m_solverMode &= ~SOLVER_USE_WARMSTARTING;
  info.m_splitImpulse = false;
  btSequentialImpulseConstraintSolver solver;
  solver.solveGroup(both, 2, manifolds.data(), static_cast<int>(manifolds.size()), nullptr, 0, info, nullptr,
                    &dispatcher_);
  kept.restore(rows, [](const Row&) { return false; });
}

WorldMemory BulletWorld::memory() const {
  WorldMemory memory;
  for (const auto& [id, body] : bodies_) memory.newborn[id] = BodyTag::newborn(*body);
  memory.allowances = allowances_;
  memory.joints = joints_.impulses();
  return memory;
}

void BulletWorld::clear() {
  // Remove static bodies too: resetPool does nothing while a body is left. The order in which contacts are solved
  // follows the order of pairs, which depends on the history of the broadphase.
  for (const auto& [id, joint] : joints_.all()) world_->removeConstraint(joint.get());
  joints_.take_out();
  for (const auto& [id, body] : bodies_) world_->removeRigidBody(body);
  bodies_.clear();
  broadphase_.resetPool(&dispatcher_);
  solver_.reset();
  rows_.clear(), of_pairs_.clear();
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
  for (auto& [id, joint] : joints) {  // by id, because their order in the solver matters
    world_->addConstraint(joint.get(), &joint->getRigidBodyB() != &world_body_);
    joint->set_impulses(memory.joints.at(id));
    joints_.add(id, std::move(joint));
  }
}

}  // namespace sunder::rigid
