#pragma once
// An engine in this process, with the rules of a session. It serves sessions, and runs without a session use it
// directly.
#include <set>

#include "coupler/core/body_ids.h"
#include "coupler/link/rigid_link.h"
#include "coupler/link/units.h"

namespace sunder::link {

/// Checks the order and arguments of requests and passes them to an engine. Throws Error: bad_message for a wrong
/// request, engine_failed where the engine returns numbers that are not finite.
class EngineHost : public RigidLink {
 public:
  explicit EngineHost(Engine& engine) : engine_(engine), info_(engine.info()) {}
  const EngineInfo& peer() const override { return info_; }
  std::vector<State> load(const World& world) override;
  void restore(const std::string& caches) override;
  std::vector<ContactRow> rows(std::int64_t tick, double window_s, const std::vector<Motion>& motions,
                               const std::vector<BodyId>& bodies) override;
  std::vector<State> window(const WindowTask& task) override;
  std::vector<State> add_bodies(const std::vector<RigidBody>& bodies) override;
  std::string save() override;
  void bye() override {}
  void abort(const std::string&, const std::string&) noexcept override {}
  void check_peer() override {}
  std::int64_t tick() const { return tick_; }

 private:
  std::vector<Motion> motions() const;
  /// The engine's states. Throws Error (engine_failed) where a number is not finite.
  std::vector<State> states() const;
  // Each refuses request `what`: before Load, without the capability, with motions that do not match the moving bodies,
  // with an unknown id.
  void loaded(const char* what) const;
  void needs(const char* capability, const char* what) const;
  void match(const std::vector<Motion>& motions, const char* what) const;
  void held(const std::vector<BodyId>& ids, const char* what) const;
  void add(const std::vector<RigidBody>& bodies, const char* what);

  InUnits engine_;
  EngineInfo info_;
  bool is_loaded_ = false, keep_windows_ = false, moved_ = false;
  std::int64_t tick_ = 0;
  BodyIds known_, moving_;
  std::set<std::uint32_t> joints_;
  // State before the last window, where windows may be taken again; last_tick_ is -1 where there is none.
  std::int64_t last_tick_ = -1;
  std::string last_caches_;
  std::vector<Motion> last_motions_;
};

}  // namespace sunder::link
