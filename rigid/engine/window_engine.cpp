#include "rigid/engine/window_engine.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "rigid/engine/checks.h"
#include "rigid/engine/hulls.h"
#include "rigid/engine/pairs.h"
#include "rigid/engine/window.h"

namespace sunder::rigid {
namespace {

struct Held {
  RigidBody body;
  HullShape shape;
};

/// A frame of a static body, in world coordinates.
Joint::Frame in_world(const Joint::Frame& frame, const BodyMotion& pose) {
  return {pose.position + pose.orientation * frame.position, pose.orientation * frame.orientation};
}

}  // namespace

struct WindowEngine::Impl {
  explicit Impl(std::unique_ptr<VelocitySolver> with) : solver(std::move(with)), pairs(solver->name()) {}

  std::unique_ptr<VelocitySolver> solver;
  std::map<BodyId, Held> bodies;
  std::map<std::uint32_t, Joint> joints;
  Pairs pairs;

  /// Predicted motions of the moving bodies, by id. Throws Error (bad_predicted_state) where they do not match the
  /// bodies.
  std::vector<const BodyMotion*> match(const std::vector<PredictedState>& predicted) const;
  /// All bodies, by id, with the average velocities that lead to these motions.
  std::vector<Mover> movers(double window_s, const std::vector<const BodyMotion*>& ends) const;
};

std::vector<const BodyMotion*> WindowEngine::Impl::match(const std::vector<PredictedState>& predicted) const {
  std::vector<const BodyMotion*> ends;
  match_predicted(
      bodies, predicted, [](const Held& held) { return held.body.is_static; },
      [&](const Held&, const BodyMotion& motion) { ends.push_back(&motion); });
  return ends;
}

std::vector<Mover> WindowEngine::Impl::movers(double window_s, const std::vector<const BodyMotion*>& ends) const {
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

WindowEngine::WindowEngine(std::unique_ptr<VelocitySolver> solver) : impl_(std::make_unique<Impl>(std::move(solver))) {}
WindowEngine::~WindowEngine() = default;

EngineInfo WindowEngine::info() const {
  using namespace link::capability;
  return {impl_->solver->name(),
          impl_->solver->version(),
          {kSpheres, kBoxes, kHalfSpaces, kConvexHulls, kCompound, kContact, kFriction, kRestitution, kJoints,
           kReleaseJoints, kMassRatios, kExportRows, kSaveRestore, kDoublePrecision, kDeterministic}};
}

void WindowEngine::add(const RigidBody& body) {
  check_body(body);
  if (impl_->bodies.count(body.id)) reject_body(body, "id", "is held already; ids are for the whole run");
  impl_->bodies.emplace(body.id, Held{body, make_hull_shape(body)});
}

void WindowEngine::set_contact_laws(const std::vector<ContactLaw>& laws) {
  check_laws(laws);
  impl_->pairs.set_contact_laws(laws);
}

void WindowEngine::add_joint(const Joint& joint) {
  check_joint(joint);
  if (impl_->joints.count(joint.id)) reject_joint(joint, "id is held already; ids are for the whole run");
  for (const BodyId id : {joint.first, joint.second})
    if (!impl_->bodies.count(id) && (id != 0 || id == joint.first))
      reject_joint(joint, fmt::format("body {} is not there; add bodies first", id));
  impl_->joints.emplace(joint.id, joint);
  if (joint.second != 0) impl_->pairs.leave_out(joint.first, joint.second);
}

// Its bodies stay left out of `pairs`, so they still do not collide.
void WindowEngine::release_joint(std::uint32_t id) { impl_->joints.erase(id); }

void WindowEngine::advance(double window_s, const std::vector<PredictedState>& predicted,
                           const std::vector<BodyId>& solved) {
  check_window(window_s);
  const auto ends = impl_->match(predicted);
  const std::vector<Mover> movers = impl_->movers(window_s, ends);
  std::vector<Meeting> meetings = impl_->pairs.find(window_s, movers);
  impl_->pairs.remember(movers, meetings);

  const std::set<BodyId> out(solved.begin(), solved.end());
  Beside beside{{}, [this](BodyId a, BodyId b) { return impl_->pairs.left_out(a, b); }};
  const auto solved_there = [&](const Meeting& m) {
    return out.count(movers[m.first].id) || out.count(movers[m.second].id);
  };
  for (const Meeting& m : meetings)
    if (solved_there(m)) beside.elsewhere.insert({movers[m.first].id, movers[m.second].id});
  std::erase_if(meetings, solved_there);
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
  const std::vector<RigidBody> there =
      take_window(*impl_->solver, window_s, movers, ends, std::move(meetings), std::move(joints), beside);
  auto next = there.begin();
  for (auto& [id, held] : impl_->bodies) held.body.motion = next++->motion;
}

std::vector<EngineState> WindowEngine::states() const {
  std::vector<EngineState> result;
  for (const auto& [id, held] : impl_->bodies)
    if (!held.body.is_static) result.push_back({id, held.body.mass, held.body.motion});
  return result;
}

std::vector<ContactRow> WindowEngine::rows(double window_s, const std::vector<PredictedState>& motions,
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

std::string WindowEngine::save() { return impl_->pairs.save(); }

void WindowEngine::restore(const std::string& caches, const std::vector<PredictedState>& motions) {
  const auto ends = impl_->match(motions);
  std::set<BodyId> known;
  for (const auto& [id, held] : impl_->bodies) known.insert(id);
  impl_->pairs.restore(caches, known);
  auto next = ends.begin();
  for (auto& [id, held] : impl_->bodies)
    if (!held.body.is_static) held.body.motion = **next++;
}

}  // namespace sunder::rigid
