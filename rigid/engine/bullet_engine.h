#pragma once
// Rigid bodies in Bullet, in double precision. The adapter moves the bodies; Bullet finds and solves contacts.
#include <memory>
#include <string>
#include <vector>

#include "rigid/engine/engine.h"

namespace sunder::rigid {

/// Properties of the adapter:
/// - A body without a contact or joint in a window ends in its predicted state, to the bit.
/// - There is no damping, sleeping, rolling resistance or gravity. In a pile at rest velocities vary by a few g H, with
///   H the window; its energy does not grow.
/// - Shapes: contacts with half spaces use true corners, contacts of two boxes true faces, spheres their true radius.
///   Other pairs use hulls with edges rounded by at most 0.5 mm inside their size. Sharp corners lose up to 0.7 mm.
/// - Look-ahead: contacts of two bodies, spheres among them, are found within kContactGap_m (bullet_world.cpp) plus the
///   distance that the two centres move relative to each other in the window. For half spaces it is the distance that
///   each corner moves, turning included.
/// - Bodies that overlap in their first window, as shards of one pane do, may keep this overlap until they separate. So
///   a body must be added where its first window starts.
/// - Restitution acts on the closing speed of the average velocities, from 0.05 m/s.
/// - Bodies added between two windows give the same result in any order.
/// - save() drops the contact impulses that solves start from: a stack that is saved in every window sinks
///   (rigid/README.md).
/// - restore() refuses motions that do not match the bodies (bad_predicted_state), and wrong saved state (bad_state).
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
