#pragma once
// Rigid bodies taken through windows with ODE's solvers, in double precision.
#include <memory>
#include <string>
#include <vector>

#include "rigid/engine/engine.h"

namespace sunder::rigid {

/// What a user should know:
/// - ODE solves contacts and joints for velocities. Where bodies touch is found here (touch.h): true sizes, no
///   margins, and seen before they meet, so that speed does not carry a body through another.
/// - A body that nothing touches in a window comes back with its handback to the bit.
/// - No damping, sleeping, rolling resistance or gravity of its own.
/// - Friction is Coulomb's along the slip, with the normal force that there would be without friction.
/// - What hangs together by more than some hundred rows is solved by sweeps without a warm start: large heaps settle
///   with overlaps that positions are moved out of, without energy.
/// - Bodies that overlap in their first window (shards of one pane) may keep that overlap until they come apart.
/// - Restitution acts on the closing speed of the average velocities, from 0.05 m/s.
/// - One thread at a time per process: ODE's generator and its initialisation are process-wide.
class OdeEngine final : public Engine {
 public:
  OdeEngine();
  ~OdeEngine() override;
  OdeEngine(const OdeEngine&) = delete;
  OdeEngine& operator=(const OdeEngine&) = delete;

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
