#include "coupler/link/host.h"

#include <cmath>
#include <limits>

#include "coupler/link/messages.h"

namespace sunder::link {

void EngineHost::loaded(const char* what) const {
  if (!is_loaded_) refuse(fmt::format("{} before Load", what));
}

void EngineHost::needs(const char* capability, const char* what) const {
  if (!info_.can(capability)) refuse(fmt::format("{}: the engine cannot do '{}'", what, capability));
}

// There must be one motion for each moving body, by ascending id. Otherwise the two sides hold different bodies.
void EngineHost::match(const std::vector<Motion>& motions, const char* what) const {
  auto next = moving_.begin();
  for (const Motion& m : motions) {
    if (next != moving_.end() && m.id > *next) break;
    if (next == moving_.end() || m.id < *next)
      refuse(fmt::format("{} of body {}: names no moving body, or comes twice or out of order", what, m.id));
    ++next;
  }
  if (next != moving_.end())
    refuse(fmt::format("{} of body {}: is missing; give one for each moving body", what, *next));
}

void EngineHost::held(const std::vector<BodyId>& ids, const char* what) const {
  for (const BodyId id : ids)
    if (!known_.contains(id)) refuse(fmt::format("{}: body {} is not held here", what, id));
}

void EngineHost::add(const std::vector<RigidBody>& bodies, const char* what) {
  for (const RigidBody& b : bodies) {
    if (!known_.insert(b.id)) refuse(fmt::format("{}[{}]: comes twice, or is held already", what, b.id));
    if (!b.is_static) moving_.insert(b.id);
    engine_.add(b);
  }
}

std::vector<Motion> EngineHost::motions() const {
  std::vector<Motion> out;
  for (const State& s : engine_.states()) out.push_back({s.id, s.motion});
  return out;
}

std::vector<State> EngineHost::states() const {
  std::vector<State> out = engine_.states();
  for (const State& s : out) {
    const BodyMotion& m = s.motion;
    const bool sound = std::isfinite(s.mass) && m.position.allFinite() && m.orientation.coeffs().allFinite() &&
                       m.velocity.allFinite() && m.angular_momentum.allFinite();
    if (sound) continue;
    Error e(Exit::kPhysics, "engine_failed",
            fmt::format("{}: body {} has a motion that is not finite; are its numbers beyond what the engine can do?",
                        info_.name, s.id));
    e.body = std::to_string(s.id);
    throw e;
  }
  return out;
}

std::vector<State> EngineHost::load(const World& world) {
  if (is_loaded_) refuse("a second Load");
  if (world.tick < 0) refuse(fmt::format("load.tick is {}", world.tick));
  if (world.keep_windows) needs(capability::kSaveRestore, "load.keep_windows");
  if (!world.joints.empty()) needs(capability::kJoints, "load.joints");
  engine_.set_unit(length_unit(world.thickness));
  engine_.set_contact_laws(world.laws);
  add(world.bodies, "bodies");
  for (const Joint& j : world.joints) {
    if (!joints_.insert(j.id).second) refuse(fmt::format("joints[{}]: comes twice", j.id));
    if (!known_.contains(j.first) || (j.second != 0 && !known_.contains(j.second)) || j.first == j.second)
      refuse(fmt::format("joints[{}]: between bodies {} and {}, one of which there is not", j.id, j.first, j.second));
    engine_.add_joint(j);
  }
  tick_ = world.tick, keep_windows_ = world.keep_windows, is_loaded_ = true;
  return states();
}

void EngineHost::restore(const std::string& caches) {
  loaded("Restore");
  needs(capability::kSaveRestore, "Restore");
  if (moved_) refuse("Restore after a window");
  engine_.restore(caches, motions());
}

std::vector<ContactRow> EngineHost::rows(std::int64_t tick, double window_s, const std::vector<Motion>& motions,
                                         const std::vector<BodyId>& bodies) {
  loaded("Export");
  needs(capability::kExportRows, "Export");
  if (tick != tick_) refuse(fmt::format("export at tick {}, expected {}", tick, tick_));
  if (!std::isfinite(window_s) || window_s <= 0.0) refuse(fmt::format("window_s is {}", window_s));
  match(motions, "motion");
  held(bodies, "export.bodies");
  return engine_.rows(window_s, motions, bodies);
}

std::vector<State> EngineHost::window(const WindowTask& w) {
  loaded("Window");
  if (w.again) {
    if (last_tick_ < 0) refuse("window.again, and there was none, or none was kept");
    tick_ = last_tick_;
  }
  if (w.tick != tick_ || w.ticks < 1 || w.ticks > std::numeric_limits<std::int64_t>::max() - tick_)
    refuse(fmt::format("window at tick {} (+{}), expected {}", w.tick, w.ticks, tick_));
  if (!std::isfinite(w.window_s) || w.window_s <= 0.0) refuse(fmt::format("window_s is {}", w.window_s));
  match(w.predicted, "predicted state");
  held(w.solved, "window.solved");
  if (!w.released.empty()) needs(capability::kReleaseJoints, "window.released");
  for (const std::uint32_t id : w.released) {
    if (!joints_.count(id)) refuse(fmt::format("released[{}]: there is no such joint", id));
    engine_.release_joint(id);
  }
  if (w.again) {
    engine_.restore(last_caches_, last_motions_);
  } else if (keep_windows_) {
    last_caches_ = engine_.save(), last_motions_ = motions(), last_tick_ = tick_;
  }
  moved_ = true;
  engine_.advance(w.window_s, w.predicted, w.solved);
  add(w.births, "births");
  if (!w.births.empty()) last_tick_ = -1;  // births cannot be undone
  tick_ += w.ticks;
  return states();
}

std::vector<State> EngineHost::add_bodies(const std::vector<RigidBody>& bodies) {
  loaded("AddBodies");
  needs(capability::kSaveRestore, "AddBodies");  // sent only in runs that repeat windows
  BodyIds ids;
  add(bodies, "bodies");
  for (const RigidBody& b : bodies) ids.insert(b.id);
  last_tick_ = -1;
  std::vector<State> out;
  for (const State& s : states())
    if (ids.contains(s.id)) out.push_back(s);
  return out;
}

std::string EngineHost::save() {
  loaded("Save");
  needs(capability::kSaveRestore, "Save");
  return engine_.save();
}

}  // namespace sunder::link
