#pragma once
// Rigid bodies whose velocities a library solves. This class finds contacts and moves the bodies.
#include <memory>
#include <string>
#include <vector>

#include "rigid/engine/engine.h"
#include "rigid/engine/velocity_solver.h"

namespace sunder::rigid {

/// Properties:
/// - The library solves contacts and joints for velocities. Contacts are found here (touch.h): with true sizes, without
///   margins, and before the bodies meet, so that fast bodies do not pass through one another.
/// - A body without a contact or joint in a window ends in its predicted state, to the bit.
/// - There is no damping, sleeping, rolling resistance or gravity.
/// - Coulomb friction acts along the slip.
/// - Bodies that overlap in their first window, as shards of one pane do, may keep this overlap until they separate.
/// - Restitution acts on the closing speed of the average velocities, from 0.05 m/s. A body that bounces on one other
///   goes on from its touch, with the speeds of that time (rebound.h), as far as nothing is in its way (way_back.h).
class WindowEngine : public Engine {
 public:
  explicit WindowEngine(std::unique_ptr<VelocitySolver> solver);
  ~WindowEngine() override;
  WindowEngine(const WindowEngine&) = delete;
  WindowEngine& operator=(const WindowEngine&) = delete;

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
