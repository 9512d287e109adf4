#pragma once
// An engine in this process, asked in the right order: the rigid side of every session, and the link of a run without
// one.
#include <set>

#include "coupler/core/body_ids.h"
#include "coupler/link/rigid_link.h"
#include "coupler/link/units.h"

namespace sunder::link {

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
  /// What the engine has. Throws Error (engine_failed) where a number of it is not finite.
  std::vector<State> states() const;
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
  // Before the last window, where windows are kept.
  std::int64_t last_tick_ = -1;
  std::string last_caches_;
  std::vector<Motion> last_motions_;
};

}  // namespace sunder::link
