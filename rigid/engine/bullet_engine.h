#pragma once
// Rigid bodies held by Bullet in double precision, taken through windows by hand.
#include <memory>
#include <string>
#include <vector>

#include "rigid/engine/engine.h"

namespace sunder::rigid {

/// What a user should know:
/// - A body that nothing touches in a window comes back with its handback to the bit.
/// - No damping, sleeping, rolling resistance or gravity of its own. A pile at rest keeps trembling by
///   a few g H, and its energy does not grow.
/// - Gaps: half spaces are met by true corners; other pairs by hulls rounded by at most 0.5 mm within
///   their size (sharp corners lose up to 0.7 mm). Contacts other than with half spaces are foreseen
///   over 2 mm: bodies should not close faster than about (thickness + 2 mm) per window.
/// - Bodies that overlap in their first window (shards of one pane) may keep that overlap until they
///   come apart; so add every body before the window in which it is born, not at a place to be left.
/// - Restitution acts on the closing speed of the average velocities, from 0.05 m/s.
/// - add() in any order between two windows gives the same result.
/// - save() forgets what contacts pushed with: a stack that is saved in every window sinks (rigid/README.md).
/// - restore() refuses motions that do not match as advance() does (bad_handback), and caches with bad_state.
class BulletEngine final : public Engine {
 public:
  BulletEngine();
  ~BulletEngine() override;
  BulletEngine(const BulletEngine&) = delete;
  BulletEngine& operator=(const BulletEngine&) = delete;

  EngineInfo info() const override;
  void add(const RigidBody& body) override;
  void set_contact_laws(const std::vector<ContactLaw>& laws) override;
  void advance(double window_s, const std::vector<PredictedState>& predicted,
               const std::vector<BodyId>& solved) override;
  std::vector<EngineState> states() const override;
  void add_joint(const Joint& joint) override;
  void release_joint(std::uint32_t id) override;
  std::vector<ContactRow> rows(double window_s, const std::vector<PredictedState>& motions,
                               const std::vector<BodyId>& bodies) override;
  std::string save() override;
  void restore(const std::string& caches, const std::vector<PredictedState>& motions) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sunder::rigid
