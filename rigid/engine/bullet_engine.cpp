#include "rigid/engine/bullet_engine.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "rigid/engine/at_touch.h"
#include "rigid/engine/bullet_caches.h"
#include "rigid/engine/bullet_shapes.h"
#include "rigid/engine/bullet_world.h"
#include "rigid/engine/checks.h"
#include "rigid/engine/way_back.h"

namespace sunder::rigid {
namespace {

btVector3 plain(const Vec3& v) { return btVector3(v.x(), v.y(), v.z()); }
Vec3 plain(const btVector3& v) { return Vec3(v.x(), v.y(), v.z()); }

btTransform bullet_pose(const BodyMotion& m) {
  const Quat& q = m.orientation;
  return btTransform(btQuaternion(q.x(), q.y(), q.z(), q.w()), plain(kLengthScale * m.position));
}

/// Orientation after h seconds of free flight from `start` by the midpoint rule; w: angular velocity at the start
/// [rad/s], `momentum`: angular momentum, constant [kg m^2/s].
Quat midpoint_turn(const RigidBody& body, const Quat& start, const Vec3& w, const Vec3& momentum, double h) {
  const auto spin_at = [&](const Quat& q) -> Vec3 {
    return q * (q.conjugate() * momentum).cwiseQuotient(body.principal_inertia);
  };
  const Quat middle = (rotation_from_vector(0.5 * h * w) * start).normalized();
  return (rotation_from_vector(h * spin_at(middle)) * start).normalized();
}

/// Orientation after a free flight of h seconds that starts with the angular velocity w [rad/s].
Quat free_turn(const RigidBody& body, const Vec3& w, double h) {
  return midpoint_turn(body, body.motion.orientation, w, body.apply_inertia(w), h);
}

/// The same for an angular momentum [kg m^2/s], in four steps of the midpoint rule.
Quat free_flight(const RigidBody& body, const Vec3& momentum, double h) {
  constexpr int kSteps = 4;
  Quat q = body.motion.orientation;
  for (int i = 0; i < kSteps; ++i) {
    const Vec3 w = q * (q.conjugate() * momentum).cwiseQuotient(body.principal_inertia);
    q = midpoint_turn(body, q, w, momentum, h / kSteps);
  }
  return q;
}

/// A body with its copies in Bullet.
struct Held {
  RigidBody body;  // the reference: Bullet's copies are in other units
  BulletShape shape;
  std::unique_ptr<btRigidBody> rigid;          // null until the first window
  std::unique_ptr<btRigidBody> mirror;         // null until rows()
  std::unique_ptr<HullShape> hulls = nullptr;  // null until a rebound needs it, and where its corners define no faces
  bool tried = false;                          // `hulls` has been asked for

  const HullShape* faces() {
    if (!std::exchange(tried, true)) try {
        hulls = std::make_unique<HullShape>(make_hull_shape(body));
      } catch (const Error&) {
        // Bullet takes bodies whose corners nearly coincide
      }
    return hulls.get();
  }
};

/// A body during a window. `linear` and `angular` are the velocities before the solve [Bullet units].
struct Transit {
  Held* held;
  const BodyMotion* predicted;
  bool fast = false, jointed = false;
  Vec3 spin = Vec3::Zero();  // [rad/s]
  btVector3 linear{0, 0, 0}, angular{0, 0, 0};
  btTransform pose = btTransform::getIdentity();
  BodyMotion start = {};
  Vec3 velocity = Vec3::Zero(), pull = Vec3::Zero();  // of the predicted motion, averages [m/s], [m/s^2]
  Shift solved = {}, relaxed = {};                    // changes of velocities by the two solves [m/s], [rad/s]
};

/// Two moving bodies, alone with one another, that bounce within the window: as they reach their touch, and their ends.
struct BouncePair {
  Transit *first, *second;
  RigidBody first_touch, second_touch;
  BodyMotion first_end = {}, second_end = {};
  bool turns_far = false;  // one of them, on its way back: no sweep can tell what it meets
};

/// Sets the average velocities that lead to the predicted state.
void aim(Transit& t, double window_s) {
  const BodyMotion &start = t.held->body.motion, &end = *t.predicted;
  const Quat turn = end.orientation * start.orientation.conjugate();
  t.spin = rotation_vector(turn) / window_s;
  const Vec3 end_spin =
      end.orientation *
      (end.orientation.conjugate() * end.angular_momentum).cwiseQuotient(t.held->body.principal_inertia);
  t.fast = end_spin.norm() * window_s > kFastTurn || t.spin.norm() * window_s > kFastTurn;
  if (t.fast) t.spin = end_spin;
  t.linear = plain(Vec3(kLengthScale / window_s * (end.position - start.position)));
  t.angular = plain(t.spin);
}

bool touched(const Transit& t) {
  const btRigidBody& rigid = *t.held->rigid;
  return !(rigid.getLinearVelocity() == t.linear && rigid.getAngularVelocity() == t.angular &&
           rigid.getWorldTransform() == t.pose);
}

Shift change(const btRigidBody& rigid, const btVector3& linear, const btVector3& angular) {
  return {plain(rigid.getLinearVelocity() - linear) / kLengthScale, plain(rigid.getAngularVelocity() - angular)};
}

/// Motion at the end of the window: the predicted state plus the solver's changes of velocities and pose.
BodyMotion arrival(const Transit& t, double window_s) {
  BodyMotion arrived = *t.predicted;  // unchanged, to the bit, where the solver changed nothing
  if (!touched(t)) return arrived;
  const btRigidBody& rigid = *t.held->rigid;
  const Vec3 dv = plain(rigid.getLinearVelocity() - t.linear) / kLengthScale;
  const Vec3 dw = plain(rigid.getAngularVelocity() - t.angular);
  const btTransform& pushed = rigid.getWorldTransform();
  const Vec3 push = plain(pushed.getOrigin() - t.pose.getOrigin()) / kLengthScale;
  btQuaternion push_turn;
  (pushed.getBasis() * t.pose.getBasis().transpose()).getRotation(push_turn);
  arrived.position += window_s * dv + push;
  // Turn the predicted pose by the difference between two free flights from the start, with and without the change of
  // angular velocity. exp(H (w + dw)) would keep w constant, and a thin shard that an impact sets spinning would gain
  // energy of order (|w| H)^2. The difference is bounded at any angular velocity.
  Quat without = free_turn(t.held->body, t.spin, window_s), with = free_turn(t.held->body, t.spin + dw, window_s);
  if (t.jointed) {
    // With a joint, fly from the angular momenta. The average angular velocity is not that of the start: an error of
    // order (|w| H)^2, which adds up where a joint acts in every window.
    const Vec3& momentum = t.predicted->angular_momentum;
    without = free_flight(t.held->body, momentum, window_s);
    with = free_flight(t.held->body, momentum + t.held->body.apply_inertia(dw), window_s);
  }
  const Quat turned = with * without.conjugate() * t.predicted->orientation;
  arrived.orientation = (Quat(push_turn.w(), push_turn.x(), push_turn.y(), push_turn.z()) * turned).normalized();
  arrived.velocity += dv;
  arrived.angular_momentum += t.held->body.apply_inertia(dw);  // with the inertia at the start, as in the solver
  return arrived;
}

std::unique_ptr<btRigidBody> make_rigid(const Held& held) {
  const RigidBody& body = held.body;
  const double mass = body.is_static ? 0.0 : kMassScale * body.mass;
  const Vec3 inertia = body.is_static ? Vec3(Vec3::Zero()) : body.principal_inertia;
  btRigidBody::btRigidBodyConstructionInfo construction(
      mass, nullptr, held.shape.get(), plain(Vec3(kMassScale * kLengthScale * kLengthScale * inertia)));
  construction.m_startWorldTransform = bullet_pose(body.motion);
  return std::make_unique<btRigidBody>(construction);
}

}  // namespace

struct BulletEngine::Impl {
  std::map<BodyId, Held> bodies;  // before the worlds, whose destructors refer to them
  std::map<std::uint32_t, Joint> joints;
  std::set<std::pair<BodyId, BodyId>> linked;  // by joints; they do not collide
  BulletWorld world{BulletWorld::Use::kMove};
  BulletWorld mirror{BulletWorld::Use::kLook};  // rows() finds contacts here and leaves `world` unchanged

  void insert_new();
  void start_over(const WorldMemory& memory);
  std::set<BodyId> known(const std::vector<BodyId>& ids, const char* what) const;
  std::vector<Transit> match(const std::vector<PredictedState>& predicted);
  BouncePair bounce(double window_s, Transit& first, Transit& second, double touch);
  void fly_on(double window_s, std::vector<Transit>& transits, const std::map<BodyId, BulletWorld::Bounce>& bounces);
};

/// Adds new bodies to the world by ascending id, in whatever order add() was called; then new joints.
void BulletEngine::Impl::insert_new() {
  for (auto& [id, held] : bodies) {
    if (held.rigid) continue;
    held.rigid = make_rigid(held);
    world.add(*held.rigid, id, held.body.contact_group);
  }
  for (const auto& [id, joint] : joints)
    if (!world.has_joint(id)) world.add_joint(joint);
}

/// Resets the worlds to a saved state, after the bodies' motions are set.
void BulletEngine::Impl::start_over(const WorldMemory& memory) {
  world.start_over(memory);
  mirror.clear();
  for (auto& [id, held] : bodies) held.mirror.reset();
}

std::vector<Transit> BulletEngine::Impl::match(const std::vector<PredictedState>& predicted) {
  std::vector<Transit> transits;
  match_predicted(
      bodies, predicted, [](const Held& held) { return held.body.is_static; },
      [&](Held& held, const BodyMotion& motion) { transits.push_back({.held = &held, .predicted = &motion}); });
  return transits;
}

/// Solves the rebound of two moving bodies at their touch, which is at about `touch`.
BouncePair BulletEngine::Impl::bounce(double window_s, Transit& first, Transit& second, double touch) {
  BouncePair pair{&first, &second, {}, {}};
  const auto flight = [](const Transit& t) { return Flight{&t.held->body, t.predicted, t.pull}; };
  const double kept = world.overlap_kept(first.held->body.id, second.held->body.id) / kLengthScale;
  const std::optional<double> met = touch_time(flight(first), flight(second), window_s, kept, touch);
  const double rest = met ? window_s - *met : 0.0;
  const auto reach = [&](Transit& t) {
    RigidBody there = before_end(t.held->body, *t.predicted, t.pull, rest);
    t.held->rigid->setCenterOfMassTransform(bullet_pose(there.motion));
    t.held->rigid->setLinearVelocity(plain(Vec3(kLengthScale * there.motion.velocity)));
    t.held->rigid->setAngularVelocity(plain(there.angular_velocity()));
    return there;
  };
  pair.first_touch = reach(first), pair.second_touch = reach(second);
  if (met) world.bounce_apart(window_s, first.held->body.id, second.held->body.id);
  const auto leave = [&](const Transit& t, RigidBody there) {
    const Shift by =
        change(*t.held->rigid, plain(Vec3(kLengthScale * there.motion.velocity)), plain(there.angular_velocity()));
    there.motion.velocity += by.linear;
    there.motion.angular_momentum += there.apply_inertia(by.turn);
    pair.turns_far = pair.turns_far || there.angular_velocity().norm() * rest > kFastTurn;
    return flown_on(there, t.pull, rest);
  };
  pair.first_end = leave(first, pair.first_touch), pair.second_end = leave(second, pair.second_touch);
  return pair;
}

/// Bodies that bounce leave their touch at its time, as far as nothing is in their way. On a static body the first
/// solve has changed their velocities from the window's start, and the second one at its end: both do so at the touch.
/// Two that both move are solved there anew, and stay at the window's end where their way is not free.
void BulletEngine::Impl::fly_on(double window_s, std::vector<Transit>& transits,
                                const std::map<BodyId, BulletWorld::Bounce>& bounces) {
  std::vector<Way> ways;
  std::vector<Held*> helds;
  std::vector<Transit*> movers;  // by way; null where static
  std::map<BodyId, int> way_of;
  const auto add_way = [&](Held& held, Transit* mover) {
    helds.push_back(&held), movers.push_back(mover);
    const BodyMotion& end = held.body.motion;
    const double bulge = mover ? 0.5 * window_s * (mover->predicted->velocity - mover->velocity).norm() : 0.0;
    ways.push_back({&held.body, mover ? mover->start : end, end, bulge, mover && mover->fast});
  };
  auto next = transits.begin();
  for (auto& [id, held] : bodies) {
    way_of[id] = static_cast<int>(ways.size());
    add_way(held, held.body.is_static ? nullptr : &*next++);
  }
  std::vector<Departure> departures;
  std::vector<double> rests;
  std::vector<BouncePair> pairs;
  for (const auto& [id, bounce_of] : bounces) {
    const int first = way_of.at(id), second = way_of.at(bounce_of.partner);
    const double touch = bounce_of.touch, rest = window_s - touch;
    if (movers[first] && movers[second]) {
      if (id < bounce_of.partner) pairs.push_back(bounce(window_s, *movers[first], *movers[second], touch));
      continue;
    }
    const auto shift = [&](int i) -> Shift {
      if (!movers[i]) return {};
      const Shift &solved = movers[i]->solved, &relaxed = movers[i]->relaxed;
      return {rest * relaxed.linear - touch * solved.linear, rest * relaxed.turn - touch * solved.turn};
    };
    departures.push_back({first, second, shift(first), shift(second)}), rests.push_back(rest);
  }
  const std::size_t on_static = departures.size();
  std::map<BodyId, BodyId> partners;
  for (const BouncePair& p : pairs) {
    const BodyId first = p.first->held->body.id, second = p.second->held->body.id;
    partners[first] = second, partners[second] = first;
    departures.push_back({way_of.at(first), way_of.at(second), shift_between(p.first_touch.motion, p.first_end),
                          shift_between(p.second_touch.motion, p.second_end)});
    for (const auto& [t, there] : {std::pair(p.first, &p.first_touch), std::pair(p.second, &p.second_touch)}) {
      add_way(*t->held, t);  // which it takes where the other one is not free
      ways[way_of.at(t->held->body.id)].end = there->motion;
    }
  }
  const auto pass = [&](int i, int k) {
    const BodyId one = ways[i].body->id, other = ways[k].body->id;
    const auto partner = partners.find(one);
    return one == other || (partner != partners.end() && partner->second == other) ||
           linked.count(ordered(one, other)) > 0;
  };
  const std::vector<double> shares = free_shares(
      ways, departures, [&](int i) { return helds[i]->faces(); }, pass);
  for (std::size_t n = 0; n < on_static; ++n) {
    const Departure& d = departures[n];
    for (const auto& [i, shift] : {std::pair(d.first, &d.first_shift), std::pair(d.second, &d.second_shift)}) {
      if (!movers[i]) continue;
      BodyMotion& end = helds[i]->body.motion;
      if (shares[n] > 0.0) end = shifted(end, *shift, shares[n]);
      const Vec3& pull = movers[i]->pull;  // it does not act in time that is left after a touch with a static body
      if (shares[n] < 1.0)
        end.velocity -= (rests[n] - time_of(shares[n], shift->linear, end.velocity, pull, rests[n])) * pull;
      helds[i]->rigid->setCenterOfMassTransform(bullet_pose(end));
    }
  }
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    for (const auto& [t, end] :
         {std::pair(pairs[n].first, &pairs[n].first_end), std::pair(pairs[n].second, &pairs[n].second_end)}) {
      if (shares[on_static + n] >= 1.0 && !pairs[n].turns_far) t->held->body.motion = *end;
      t->held->rigid->setCenterOfMassTransform(bullet_pose(t->held->body.motion));
    }
  }
}

std::set<BodyId> BulletEngine::Impl::known(const std::vector<BodyId>& ids, const char* what) const {
  for (const BodyId id : ids)
    if (!bodies.count(id)) reject_predicted(id, fmt::format("'{}' names it, and there is no such body", what));
  return {ids.begin(), ids.end()};
}

BulletEngine::BulletEngine() : impl_(std::make_unique<Impl>()) {}
BulletEngine::~BulletEngine() = default;

EngineInfo BulletEngine::info() const {
  using namespace link::capability;
  const int version = btGetVersion();
  return {"bullet",
          fmt::format("{}.{}", version / 100, version % 100),
          {kSpheres, kBoxes, kHalfSpaces, kConvexHulls, kCompound, kContact, kFriction, kRestitution, kJoints,
           kReleaseJoints, kExportRows, kSaveRestore, kDoublePrecision, kDeterministic}};
}

void BulletEngine::add(const RigidBody& body) {
  check_body(body);
  if (impl_->bodies.count(body.id)) reject_body(body, "id", "is held already; ids are for the whole run");
  impl_->bodies.emplace(body.id, Held{body, make_bullet_shape(body), nullptr, nullptr});
}

void BulletEngine::add_joint(const Joint& joint) {
  check_joint(joint);
  if (impl_->joints.count(joint.id)) reject_joint(joint, "its id is held already");
  bool any_moves = false;
  for (const BodyId id : {joint.first, joint.second}) {
    if (id == 0) continue;  // the world
    const auto held = impl_->bodies.find(id);
    if (held == impl_->bodies.end()) reject_joint(joint, fmt::format("there is no body {}; add it first", id));
    any_moves = any_moves || !held->second.body.is_static;
  }
  if (!any_moves) reject_joint(joint, "nothing that it holds moves; leave it out");
  impl_->joints.emplace(joint.id, joint);
  impl_->linked.insert(ordered(joint.first, joint.second));
}

void BulletEngine::release_joint(std::uint32_t id) { impl_->world.release_joint(id); }

void BulletEngine::set_contact_laws(const std::vector<ContactLaw>& laws) {
  check_laws(laws);
  impl_->world.set_contact_laws(laws);
  impl_->mirror.set_contact_laws(laws);
}

void BulletEngine::advance(double window_s, const std::vector<PredictedState>& predicted,
                           const std::vector<BodyId>& solved) {
  check_window(window_s);
  std::vector<Transit> transits = impl_->match(predicted);
  const std::set<BodyId> left_out = impl_->known(solved, "solved");
  impl_->insert_new();

  for (Transit& t : transits) {
    aim(t, window_s);
    t.held->rigid->setLinearVelocity(t.linear);
    t.held->rigid->setAngularVelocity(t.angular);
    t.pose = t.held->rigid->getWorldTransform();
    t.start = t.held->body.motion;
    t.velocity = plain(t.linear) / kLengthScale;
    t.pull = 2.0 / window_s * (t.predicted->velocity - t.velocity);
  }

  const BulletWorld::Ahead ahead{
      .end_of =
          [&](BodyId id) {
            const auto by_id = [](const Transit& t, BodyId sought) { return t.held->body.id < sought; };
            return bullet_pose(arrival(*std::lower_bound(transits.begin(), transits.end(), id, by_id), window_s));
          },
      .put_back =
          [&] {
            for (Transit& t : transits) {
              t.held->rigid->setCenterOfMassTransform(t.pose);
              t.held->rigid->setLinearVelocity(t.linear);
              t.held->rigid->setAngularVelocity(t.angular);
            }
          }};
  const bool in_contact = impl_->world.detect(window_s, left_out), joined = impl_->world.choose_joints(left_out);
  for (Transit& t : transits) t.jointed = joined && impl_->world.holds(t.held->body.id);
  if (in_contact || joined) impl_->world.solve(window_s, ahead);
  const bool any_touched = joined || std::any_of(transits.begin(), transits.end(), touched);

  for (Transit& t : transits) {
    t.held->body.motion = arrival(t, window_s);
    t.held->rigid->setCenterOfMassTransform(bullet_pose(t.held->body.motion));
  }
  if (!any_touched) return;

  for (Transit& t : transits) {
    btRigidBody& rigid = *t.held->rigid;
    t.solved = change(rigid, t.linear, t.angular);
    t.linear = plain(Vec3(kLengthScale * t.held->body.motion.velocity));
    t.angular = plain(t.held->body.angular_velocity());
    rigid.setLinearVelocity(t.linear);
    rigid.setAngularVelocity(t.angular);
  }
  const auto bounces = impl_->world.relax(window_s, [&](BodyId id) {
    const auto by_id = [](const Transit& t, BodyId sought) { return t.held->body.id < sought; };
    const auto at = std::lower_bound(transits.begin(), transits.end(), id, by_id);
    const bool moves = at != transits.end() && at->held->body.id == id;
    return moves ? plain(Vec3(kLengthScale * at->pull)) : btVector3(0, 0, 0);
  });
  for (Transit& t : transits) {
    const btRigidBody& rigid = *t.held->rigid;
    if (rigid.getLinearVelocity() == t.linear && rigid.getAngularVelocity() == t.angular) continue;
    RigidBody& body = t.held->body;
    t.relaxed = change(rigid, t.linear, t.angular);
    body.motion.velocity += t.relaxed.linear;
    body.motion.angular_momentum += body.apply_inertia(t.relaxed.turn);
  }
  if (!bounces.empty()) impl_->fly_on(window_s, transits, bounces);
}

std::vector<EngineState> BulletEngine::states() const {
  std::vector<EngineState> result;
  for (const auto& [id, held] : impl_->bodies) {
    if (held.body.is_static) continue;
    const double mass = held.rigid ? held.rigid->getMass() / kMassScale : held.body.mass;
    result.push_back({id, mass, held.body.motion});
  }
  return result;
}

std::vector<ContactRow> BulletEngine::rows(double window_s, const std::vector<PredictedState>& motions,
                                           const std::vector<BodyId>& bodies) {
  check_window(window_s);
  std::vector<Transit> transits = impl_->match(motions);
  const std::set<BodyId> listed = impl_->known(bodies, "bodies");
  for (auto& [id, held] : impl_->bodies) {
    if (held.mirror) continue;
    held.mirror = make_rigid(held);
    impl_->mirror.add(*held.mirror, id, held.body.contact_group);
  }
  for (const auto& [id, joint] : impl_->joints)
    if (!impl_->mirror.has_joint(id)) impl_->mirror.add_joint(joint);
  for (Transit& t : transits) {
    aim(t, window_s);
    btRigidBody& mirror = *t.held->mirror;
    mirror.setCenterOfMassTransform(bullet_pose(t.held->body.motion));
    mirror.setLinearVelocity(t.linear);
    mirror.setAngularVelocity(t.angular);
  }
  std::vector<ContactRow> rows;
  for (const SeenContact& contact : impl_->mirror.see(window_s, listed)) {
    const btManifoldPoint& point = *contact.point;
    rows.push_back({.first = contact.bodies.first,
                    .second = contact.bodies.second,
                    .first_point = plain(point.m_localPointA) / kLengthScale,
                    .second_point = plain(point.m_localPointB) / kLengthScale,
                    .normal = plain(point.m_normalWorldOnB).normalized(),
                    .friction = contact.law.friction,
                    .restitution = contact.law.restitution,
                    .allowance = impl_->world.allowance(contact.bodies, contact.depth) / kLengthScale});
  }
  return rows;
}

std::string BulletEngine::save() {
  impl_->insert_new();  // so that they are newborn here as after restore()
  const WorldMemory memory = impl_->world.memory();
  impl_->start_over(memory);
  return encode_caches(memory);
}

void BulletEngine::restore(const std::string& caches, const std::vector<PredictedState>& motions) {
  const WorldMemory memory = decode_caches(caches);
  const auto same_key = [](const auto& a, const auto& b) { return a.first == b.first; };
  if (!std::equal(memory.newborn.begin(), memory.newborn.end(), impl_->bodies.begin(), impl_->bodies.end(), same_key))
    throw Error(Exit::kBadInput, "bad_state",
                fmt::format("the caches are of {} bodies, the engine has {}, or others; add the same ones",
                            memory.newborn.size(), impl_->bodies.size()));
  if (!std::equal(memory.joints.begin(), memory.joints.end(), impl_->joints.begin(), impl_->joints.end(), same_key))
    throw Error(Exit::kBadInput, "bad_state",
                fmt::format("the caches are of {} joints, the engine has {}, or others; add the same ones",
                            memory.joints.size(), impl_->joints.size()));
  const std::vector<Transit> transits = impl_->match(motions);
  impl_->insert_new();
  for (const Transit& t : transits) {
    t.held->body.motion = *t.predicted;
    t.held->rigid->setCenterOfMassTransform(bullet_pose(*t.predicted));
  }
  impl_->start_over(memory);
}

}  // namespace sunder::rigid
