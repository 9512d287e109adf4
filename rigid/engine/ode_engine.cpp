#include "rigid/engine/ode_engine.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "rigid/engine/checks.h"
#include "rigid/engine/ode_pairs.h"
#include "rigid/engine/ode_shapes.h"
#include "rigid/engine/ode_solver.h"

namespace sunder::rigid {
namespace {

/// Turn per window above which the average angular velocity is not trusted: its logarithm is ambiguous from pi on. The
/// handback's own is solved on instead.
constexpr double kFastTurn = 0.7;  // [rad]
/// Meeting slower than this is no impact and does not bounce: resting closes with g H per window.
constexpr double kImpactSpeed = 0.05;  // [m/s]
/// Overlap that is left alone, and the share of what is more that a window takes back by moving poses.
constexpr double kSlack_m = 5e-6;
constexpr double kPushShare = 0.2;  // [-]
/// Of the joints' error, all: a body on a joint then goes along the chord of its arc, and the velocity, turned by the
/// second solve, keeps its magnitude. With less it loses energy of order (|w| H)^2 in every window.
constexpr double kJointShare = 1.0;  // [-]
constexpr double kUnitTolerance = 1e-6;

struct Held {
  RigidBody body;
  OdeShape shape;
};

[[noreturn]] void reject_joint(const Joint& joint, const std::string& what) {
  Error error(Exit::kBadInput, "bad_joint", fmt::format("joint {} '{}': {}", joint.id, joint.name, what));
  error.field = "joint";
  throw error;
}

void check_frame(const Joint& joint, const Joint::Frame& frame, const char* which) {
  if (!frame.position.allFinite() || !frame.orientation.coeffs().allFinite())
    reject_joint(joint, fmt::format("{} holds a number that is not finite", which));
  const double length = frame.orientation.norm();
  if (std::abs(length - 1.0) > kUnitTolerance)
    reject_joint(joint, fmt::format("{}.orientation has length {}, must be 1; normalize it", which, length));
}

/// A frame of a body that does not move, in the world.
Joint::Frame in_world(const Joint::Frame& frame, const BodyMotion& pose) {
  return {pose.position + pose.orientation * frame.position, pose.orientation * frame.orientation};
}

/// Orientation after a free flight of h seconds that starts with this angular velocity [rad/s].
Quat free_turn(RigidBody body, const Vec3& spin, double h) {
  body.motion.angular_momentum = body.apply_inertia(spin);
  body.drift(h);
  return body.motion.orientation;
}

}  // namespace

struct OdeEngine::Impl {
  OdeLibrary library;
  std::map<BodyId, Held> bodies;
  std::map<std::uint32_t, Joint> joints;
  Pairs pairs;

  /// The moving bodies' new motions, by id. Throws Error (bad_handback).
  std::vector<const BodyMotion*> match(const std::vector<Handback>& handbacks) const;
  /// Every body, by id, with the average velocities that lead to these motions.
  std::vector<Mover> movers(double window_s, const std::vector<const BodyMotion*>& ends) const;
};

std::vector<const BodyMotion*> OdeEngine::Impl::match(const std::vector<Handback>& handbacks) const {
  std::vector<const BodyMotion*> ends;
  auto next = handbacks.begin();
  for (const auto& [id, held] : bodies) {
    if (held.body.is_static) continue;
    if (next == handbacks.end() || next->id > id) reject_handback(id, "is missing; give one for each moving body");
    if (next->id < id) break;
    check_handback(*next);
    ends.push_back(&next->motion);
    ++next;
  }
  if (next != handbacks.end())
    reject_handback(next->id, "names no moving body, or comes twice or out of order; give one each, by ascending id");
  return ends;
}

std::vector<Mover> OdeEngine::Impl::movers(double window_s, const std::vector<const BodyMotion*>& ends) const {
  std::vector<Mover> all;
  auto next = ends.begin();
  for (const auto& [id, held] : bodies) {
    Mover& m = all.emplace_back();
    m.id = id, m.body = &held.body, m.shape = &held.shape;
    if (held.body.is_static) continue;
    const BodyMotion &start = held.body.motion, &end = **next++;
    m.velocity = (end.position - start.position) / window_s;
    m.spin = rotation_vector(end.orientation * start.orientation.conjugate()) / window_s;
    RigidBody at_end = held.body;
    at_end.motion = end;
    const Vec3 end_spin = at_end.angular_velocity();
    if (std::max(end_spin.norm(), m.spin.norm()) * window_s > kFastTurn) m.spin = end_spin;
  }
  return all;
}

namespace {

/// Bodies on their way through a window, indexed as the movers.
class Transit {
 public:
  Transit(double window_s, const std::vector<Mover>& movers, const std::vector<const BodyMotion*>& ends,
          std::vector<Meeting> meetings, std::vector<SolverJoint> joints)
      : h_(window_s),
        movers_(movers),
        meetings_(std::move(meetings)),
        joints_(std::move(joints)),
        acted_(meetings_.size()) {
    auto next = ends.begin();
    for (const Mover& m : movers_) {
      ends_.push_back(*m.body);
      if (!m.body->is_static) ends_.back().motion = **next++;
    }
  }

  /// Where the bodies come, and how they move there.
  const std::vector<RigidBody>& run() {
    if (meetings_.empty() && joints_.empty()) return ends_;
    if (solve()) push(), relax();
    return ends_;
  }

 private:
  /// What slots of the solver are; static bodies have none.
  template <class Make>
  void gather(Make make) {
    slots_.assign(movers_.size(), -1);
    solver_bodies_.clear();
    for (std::size_t i = 0; i < movers_.size(); ++i) {
      if (movers_[i].body->is_static) continue;
      slots_[i] = static_cast<int>(solver_bodies_.size());
      solver_bodies_.push_back(make(i));
    }
  }
  SolverBody at(std::size_t i, const BodyMotion& pose, const Vec3& velocity, const Vec3& spin) const {
    const RigidBody& b = *movers_[i].body;
    return {b.mass, b.principal_inertia, pose.position, pose.orientation, velocity, spin};
  }
  Vec3 point(int i, const Vec3& local, bool at_end) const {
    const BodyMotion& m = at_end ? ends_[i].motion : movers_[i].body->motion;
    return m.position + m.orientation * local;
  }
  double gap_at_end(const Meeting& m) const {
    return m.normal.dot(point(m.first, m.first_point, true) - point(m.second, m.second_point, true)) + m.allowance;
  }
  SolverContact contact(const Meeting& m, bool at_end, double friction, double target) const {
    const Vec3 middle = 0.5 * (point(m.first, m.first_point, at_end) + point(m.second, m.second_point, at_end));
    return {slots_[m.first], slots_[m.second], middle, m.normal, friction, target, false};
  }
  std::vector<SolverJoint> joints() const {
    std::vector<SolverJoint> all = joints_;
    for (SolverJoint& j : all) j.first = slots_[j.first], j.second = j.second < 0 ? -1 : slots_[j.second];
    return all;
  }

  /// On the average velocities: contacts may close their gaps. False where nothing came of it.
  bool solve() {
    gather([&](std::size_t i) { return at(i, movers_[i].body->motion, movers_[i].velocity, movers_[i].spin); });
    std::vector<SolverContact> contacts;
    for (const Meeting& m : meetings_)
      contacts.push_back(contact(m, false, m.law->friction, -std::max(0.0, m.gap) / h_));
    solve_velocities(h_, kJointShare, solver_bodies_, joints(), contacts);
    for (std::size_t k = 0; k < contacts.size(); ++k) acted_[k] = contacts[k].acted;
    bool any = false;
    for (std::size_t i = 0; i < movers_.size(); ++i) {
      if (slots_[i] < 0) continue;
      const SolverBody& s = solver_bodies_[slots_[i]];
      const Vec3 dv = s.velocity - movers_[i].velocity, dw = s.spin - movers_[i].spin;
      if (dv.isZero(0.0) && dw.isZero(0.0)) continue;
      any = true;
      const RigidBody& start = *movers_[i].body;
      BodyMotion& end = ends_[i].motion;
      end.position += h_ * dv;
      // Turned by the difference between two free flights from the start. exp(H (w + dw)) would hold w fixed, and a
      // thin shard that an impact sets spinning would gain energy of order (|w| H)^2.
      const Quat without = free_turn(start, movers_[i].spin, h_), with = free_turn(start, s.spin, h_);
      end.orientation = (with * without.conjugate() * end.orientation).normalized();
      end.velocity += dv;
      end.angular_momentum += start.apply_inertia(dw);
    }
    return any;
  }

  /// Moves poses out of overlaps; velocities do not hear of it.
  void push() {
    const auto too_deep = [&](const Meeting& m) { return gap_at_end(m) < -kSlack_m; };
    if (std::none_of(meetings_.begin(), meetings_.end(), too_deep)) return;
    gather([&](std::size_t i) { return at(i, ends_[i].motion, Vec3::Zero(), Vec3::Zero()); });
    std::vector<SolverContact> contacts;
    for (const Meeting& m : meetings_) {
      const double gap = gap_at_end(m);
      contacts.push_back(
          contact(m, true, 0.0, gap > 0.0 ? -gap / h_ : kPushShare * std::max(0.0, -gap - kSlack_m) / h_));
    }
    solve_velocities(h_, 0.0, solver_bodies_, joints(), contacts);
    for (std::size_t i = 0; i < movers_.size(); ++i) {
      if (slots_[i] < 0) continue;
      const SolverBody& s = solver_bodies_[slots_[i]];
      if (s.velocity.isZero(0.0) && s.spin.isZero(0.0)) continue;
      ends_[i].motion.position += h_ * s.velocity;
      ends_[i].motion.orientation = (rotation_from_vector(h_ * s.spin) * ends_[i].motion.orientation).normalized();
    }
  }

  /// Velocities alone, where the bodies have come to: contacts that pushed or touch now do not close.
  void relax() {
    gather(
        [&](std::size_t i) { return at(i, ends_[i].motion, ends_[i].motion.velocity, ends_[i].angular_velocity()); });
    const std::vector<SolverBody> before = solver_bodies_;
    std::vector<SolverContact> contacts;
    for (std::size_t k = 0; k < meetings_.size(); ++k) {
      const Meeting& m = meetings_[k];
      if (!acted_[k] && gap_at_end(m) > 0.0) continue;
      const bool bounces = acted_[k] && m.approach > kImpactSpeed;
      contacts.push_back(contact(m, true, m.law->friction, bounces ? m.law->restitution * m.approach : 0.0));
    }
    solve_velocities(h_, 0.0, solver_bodies_, joints(), contacts);
    for (std::size_t i = 0; i < movers_.size(); ++i) {
      if (slots_[i] < 0) continue;
      const SolverBody &was = before[slots_[i]], &is = solver_bodies_[slots_[i]];
      const Vec3 dv = is.velocity - was.velocity, dw = is.spin - was.spin;
      if (dv.isZero(0.0) && dw.isZero(0.0)) continue;
      ends_[i].motion.velocity += dv;
      ends_[i].motion.angular_momentum += ends_[i].apply_inertia(dw);
    }
  }

  double h_;
  const std::vector<Mover>& movers_;
  std::vector<Meeting> meetings_;
  std::vector<SolverJoint> joints_;  // between movers
  std::vector<char> acted_;          // by meeting
  std::vector<RigidBody> ends_;
  std::vector<int> slots_;  // by mover
  std::vector<SolverBody> solver_bodies_;
};

}  // namespace

OdeEngine::OdeEngine() : impl_(std::make_unique<Impl>()) {}
OdeEngine::~OdeEngine() = default;

EngineInfo OdeEngine::info() const {
  using namespace link::capability;
  return {"ode",
          ode_version(),
          {kSpheres, kBoxes, kHalfSpaces, kConvexHulls, kCompound, kContact, kFriction, kRestitution, kJoints,
           kExportRows, kSaveRestore, kDoublePrecision, kDeterministic}};
}

void OdeEngine::add(const RigidBody& body) {
  check_body(body);
  if (impl_->bodies.count(body.id)) reject_body(body, "id", "is held already; ids are for the whole run");
  impl_->bodies.emplace(body.id, Held{body, make_ode_shape(body)});
}

void OdeEngine::set_contact_laws(const std::vector<ContactLaw>& laws) {
  check_laws(laws);
  impl_->pairs.set_contact_laws(laws);
}

void OdeEngine::add_joint(const Joint& joint) {
  if (joint.id == 0) reject_joint(joint, "id is 0, which is never used; count from 1");
  if (impl_->joints.count(joint.id)) reject_joint(joint, "id is held already; ids are for the whole run");
  for (const BodyId id : {joint.first, joint.second})
    if (!impl_->bodies.count(id) && (id != 0 || id == joint.first))
      reject_joint(joint, fmt::format("body {} is not there; add bodies first", id));
  if (joint.first == joint.second) reject_joint(joint, "holds a body to itself; name two");
  check_frame(joint, joint.first_frame, "first_frame");
  check_frame(joint, joint.second_frame, "second_frame");
  impl_->joints.emplace(joint.id, joint);
  if (joint.second != 0) impl_->pairs.leave_out(joint.first, joint.second);
}

void OdeEngine::advance(double window_s, const std::vector<Handback>& handbacks, const std::vector<BodyId>& solved) {
  check_window(window_s);
  const auto ends = impl_->match(handbacks);
  const std::vector<Mover> movers = impl_->movers(window_s, ends);
  std::vector<Meeting> meetings = impl_->pairs.find(window_s, movers);
  impl_->pairs.remember(movers, meetings);

  const std::set<BodyId> out(solved.begin(), solved.end());
  meetings.erase(
      std::remove_if(meetings.begin(), meetings.end(),
                     [&](const Meeting& m) { return out.count(movers[m.first].id) || out.count(movers[m.second].id); }),
      meetings.end());
  const auto index = [&](BodyId id) {
    return static_cast<int>(std::lower_bound(movers.begin(), movers.end(), id,
                                             [](const Mover& m, BodyId wanted) { return m.id < wanted; }) -
                            movers.begin());
  };
  std::vector<SolverJoint> joints;
  for (const auto& [id, joint] : impl_->joints) {
    if (out.count(joint.first) || out.count(joint.second)) continue;
    SolverJoint j{joint.kind, index(joint.first), joint.second == 0 ? -1 : index(joint.second), joint.first_frame,
                  joint.second_frame};
    if (j.second >= 0 && movers[j.second].body->is_static)
      j.second_frame = in_world(j.second_frame, movers[j.second].body->motion), j.second = -1;
    if (movers[j.first].body->is_static) {
      if (j.second < 0) continue;  // neither side moves
      j.first_frame = in_world(j.first_frame, movers[j.first].body->motion);
      std::swap(j.first_frame, j.second_frame);
      j.first = j.second, j.second = -1;
    }
    joints.push_back(j);
  }
  Transit transit(window_s, movers, ends, std::move(meetings), std::move(joints));
  const std::vector<RigidBody>& there = transit.run();
  auto next = there.begin();
  for (auto& [id, held] : impl_->bodies) held.body.motion = next++->motion;
}

std::vector<EngineState> OdeEngine::states() const {
  std::vector<EngineState> result;
  for (const auto& [id, held] : impl_->bodies)
    if (!held.body.is_static) result.push_back({id, held.body.mass, held.body.motion});
  return result;
}

std::vector<ContactRow> OdeEngine::rows(double window_s, const std::vector<Handback>& motions,
                                        const std::vector<BodyId>& bodies) {
  check_window(window_s);
  const auto ends = impl_->match(motions);
  const std::vector<Mover> movers = impl_->movers(window_s, ends);
  const std::set<BodyId> wanted(bodies.begin(), bodies.end());
  std::vector<ContactRow> result;
  for (const Meeting& m : impl_->pairs.find(window_s, movers)) {
    const BodyId first = movers[m.first].id, second = movers[m.second].id;
    if (!wanted.count(first) && !wanted.count(second)) continue;
    result.push_back(
        {first, second, m.first_point, m.second_point, m.normal, m.law->friction, m.law->restitution, m.allowance});
  }
  return result;
}

std::string OdeEngine::save() { return impl_->pairs.save(); }

void OdeEngine::restore(const std::string& caches, const std::vector<Handback>& motions) {
  const auto ends = impl_->match(motions);
  std::set<BodyId> known;
  for (const auto& [id, held] : impl_->bodies) known.insert(id);
  impl_->pairs.restore(caches, known);
  auto next = ends.begin();
  for (auto& [id, held] : impl_->bodies)
    if (!held.body.is_static) held.body.motion = **next++;
}

}  // namespace sunder::rigid
