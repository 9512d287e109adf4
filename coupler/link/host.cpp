#include "coupler/link/host.h"

#include <cmath>
#include <set>

namespace sunder::link {
namespace {

[[noreturn]] void refuse(const std::string& message) { throw Error(Exit::kPeerLost, "bad_message", message); }

}  // namespace

void EngineHost::loaded(const char* what) const {
  if (!is_loaded_) refuse(fmt::format("{} before Load", what));
}

std::vector<Motion> EngineHost::motions() const {
  std::vector<Motion> out;
  for (const State& s : engine_.states()) out.push_back({s.id, s.motion});
  return out;
}

std::vector<State> EngineHost::load(const World& world) {
  if (is_loaded_) refuse("a second Load");
  if (world.tick < 0) refuse(fmt::format("load.tick is {}", world.tick));
  if (world.keep_windows && !info_.can(capability::kSaveRestore))
    refuse("load.keep_windows: the engine cannot do 'save_restore'");
  if (!world.joints.empty() && !info_.can(capability::kJoints)) refuse("load.joints: the engine cannot do 'joints'");
  engine_.set_contact_laws(world.laws);
  std::set<BodyId> known;
  for (const RigidBody& b : world.bodies) {
    if (!known.insert(b.id).second) refuse(fmt::format("bodies[{}]: comes twice", b.id));
    engine_.add(b);
  }
  std::set<std::uint32_t> joints;
  for (const Joint& j : world.joints) {
    if (!joints.insert(j.id).second) refuse(fmt::format("joints[{}]: comes twice", j.id));
    if (!known.count(j.first) || (j.second != 0 && !known.count(j.second)) || j.first == j.second)
      refuse(fmt::format("joints[{}]: between bodies {} and {}, one of which there is not", j.id, j.first, j.second));
    engine_.add_joint(j);
  }
  tick_ = world.tick, keep_windows_ = world.keep_windows, is_loaded_ = true;
  return engine_.states();
}

void EngineHost::restore(const std::string& caches) {
  loaded("Restore");
  if (moved_) refuse("Restore after a window");
  engine_.restore(caches, motions());
}

std::vector<ContactRow> EngineHost::rows(std::int64_t tick, double window_s, const std::vector<Motion>& motions,
                                         const std::vector<BodyId>& bodies) {
  loaded("Export");
  if (tick != tick_) refuse(fmt::format("export at tick {}, expected {}", tick, tick_));
  if (!std::isfinite(window_s) || window_s <= 0.0) refuse(fmt::format("window_s is {}", window_s));
  return engine_.rows(window_s, motions, bodies);
}

std::vector<State> EngineHost::window(const WindowTask& w) {
  loaded("Window");
  if (w.again) {
    if (last_tick_ < 0) refuse("window.again, and there was none, or none was kept");
    tick_ = last_tick_;
  }
  if (w.tick != tick_ || w.ticks < 1)
    refuse(fmt::format("window at tick {} (+{}), expected {}", w.tick, w.ticks, tick_));
  if (!std::isfinite(w.window_s) || w.window_s <= 0.0) refuse(fmt::format("window_s is {}", w.window_s));
  if (w.again) {
    engine_.restore(last_caches_, last_motions_);
  } else if (keep_windows_) {
    last_caches_ = engine_.save(), last_motions_ = motions(), last_tick_ = tick_;
  }
  moved_ = true;
  engine_.advance(w.window_s, w.handbacks, w.solved);
  for (const RigidBody& b : w.births) engine_.add(b);
  if (!w.births.empty()) last_tick_ = -1;  // what was born cannot be taken back
  tick_ += w.ticks;
  return engine_.states();
}

std::vector<State> EngineHost::add_bodies(const std::vector<RigidBody>& bodies) {
  loaded("AddBodies");
  std::set<BodyId> ids;
  for (const RigidBody& b : bodies) engine_.add(b), ids.insert(b.id);
  last_tick_ = -1;
  std::vector<State> out;
  for (const State& s : engine_.states())
    if (ids.count(s.id)) out.push_back(s);
  return out;
}

std::string EngineHost::save() {
  loaded("Save");
  return engine_.save();
}

}  // namespace sunder::link
