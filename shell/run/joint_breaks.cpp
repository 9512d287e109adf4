// What the engine has to be able to do, and when joints let go.
#include <algorithm>
#include <cmath>

#include "coupler/core/error.h"
#include "shell/run/run.h"

namespace sunder::shell {
namespace {

Joint::Frame placed(const Proxy* body, const Joint::Frame& f) {
  if (!body) return f;
  const BodyMotion& m = body->body.motion;
  return {m.position + m.orientation * f.position, m.orientation * f.orientation};
}

}  // namespace

void Run::check_engine() const {
  const link::EngineInfo& peer = rigid_->peer();
  const auto need = [&](const char* what, const std::string& why) {
    require(peer.can(what), "the engine '{}' cannot do '{}', which {}; take another engine, or change the scene",
            peer.name, what, why);
  };
  using namespace link::capability;
  for (const RigidBody& b : setup_.bodies) {
    if (std::holds_alternative<SphereShape>(b.shape)) need(kSpheres, "body '" + b.name + "' needs");
    if (std::holds_alternative<BoxShape>(b.shape)) need(kBoxes, "body '" + b.name + "' needs");
    if (std::holds_alternative<HalfSpaceShape>(b.shape)) need(kHalfSpaces, "body '" + b.name + "' needs");
    const auto* convex = std::get_if<ConvexShape>(&b.shape);
    if (convex) need(kConvexHulls, "body '" + b.name + "' needs");
    if (convex && convex->parts.size() > 1) need(kCompound, "body '" + b.name + "' needs");
  }
  for (const Joint& j : setup_.joints) need(kJoints, "joint '" + j.name + "' needs");
  for (std::size_t i = 0; i < setup_.joints.size(); ++i)
    if (setup_.breaks[i].can()) need(kReleaseJoints, "joint '" + setup_.joints[i].name + "', which breaks, needs");
  if (setup_.can_crack())
    for (const char* what : {kConvexHulls, kCompound}) need(what, "shards need; or leave strength and cuts out");
  if (setup_.coupling.scheme == CouplingRules::Scheme::kExported) need(kExportRows, "coupling.scheme EXPORTED needs");
  if (setup_.coupling.scheme == CouplingRules::Scheme::kIterated) need(kSaveRestore, "coupling.scheme ITERATED needs");
}

std::vector<std::string> Run::engine_notes() const {
  using namespace link::capability;
  const link::EngineInfo& peer = rigid_->peer();
  const auto moving = static_cast<std::size_t>(
      std::count_if(setup_.bodies.begin(), setup_.bodies.end(), [](const RigidBody& b) { return !b.is_static; }));
  const bool meet = setup_.can_crack() || (moving > 0 && setup_.bodies.size() > 1);
  std::vector<std::string> notes;
  const auto without = [&](const char* what, const std::string& why) {
    if (!peer.can(what)) notes.push_back(fmt::format("the engine '{}' cannot do '{}': {}", peer.name, what, why));
  };
  if (meet && !peer.can(kContact)) {
    without(kContact, "bodies and shards pass through one another, shells alone stop them");
  } else if (meet) {
    const auto any = [&](auto has) { return std::any_of(setup_.laws.begin(), setup_.laws.end(), has); };
    if (any([](const ContactLaw& law) { return law.friction > 0.0; })) without(kFriction, "bodies slide freely");
    if (any([](const ContactLaw& law) { return law.restitution > 0.0; })) without(kRestitution, "bodies do not bounce");
  }
  const bool held = moving > 0 && (setup_.bodies.size() > 1 || !setup_.joints.empty());
  if (held && !setup_.shells.empty() && setup_.coupling.scheme == CouplingRules::Scheme::kProxy)
    without(
        kExportRows,
        fmt::format("a body that is squeezed between a shell and another body, or that a joint holds, may gain "
                    "energy where k H^2/M passes {:g} (coupling in run.json says what it came to); shorten window_s",
                    setup_.coupling.export_above));
  if (setup_.checkpoint_interval > 0.0) without(kSaveRestore, "no checkpoints are written, --resume has nothing");
  return notes;
}

// Frames of a joint that is not strained coincide at the start.
void Run::let_joints_go() {
  const auto body = [&](BodyId id) -> const Proxy* { return id == 0 ? nullptr : &proxies_[id - 1]; };
  for (std::size_t i = 0; i < setup_.joints.size(); ++i) {
    const JointBreak& b = setup_.breaks[i];
    if (let_go_s_[i] >= 0.0 || !b.can()) continue;
    const Joint& j = setup_.joints[i];
    const Joint::Frame first = placed(body(j.first), j.first_frame), second = placed(body(j.second), j.second_frame);
    const double angle = rotation_vector(second.orientation.conjugate() * first.orientation).norm();
    const double extension = std::abs((first.position - second.position).dot(second.orientation * Vec3::UnitZ()));
    if (time() < b.time - 1e-6 * setup_.tick && angle < b.angle && extension < b.extension) continue;
    let_go_s_[i] = time();
    released_.insert(std::upper_bound(released_.begin(), released_.end(), j.id), j.id);
  }
}

}  // namespace sunder::shell
