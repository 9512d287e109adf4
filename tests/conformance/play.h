#pragma once
// A session with the engine in which this side plays the shell: its copies of the bodies fly freely through each window
// and are handed back.
#include <map>
#include <memory>
#include <vector>

#include "coupler/link/remote.h"
#include "tests/conformance/process.h"

namespace sunder::conformance {

struct Scene {
  link::World world;  // bodies in any order
  Vec3 gravity = Vec3::Zero();
  double window_s = 1e-3;
};

class Play {
 public:
  /// Starts the engine and says Hello and Load. Throws Error as link::RigidLink does.
  Play(const Target& target, Scene scene);
  ~Play();
  /// As they are now: what a fresh engine gets that is to go on from here.
  Scene now() const;

  const link::EngineInfo& peer() const { return peer_; }
  link::RigidLink& link() { return *link_; }

  /// Where each moving body would come in a window by itself.
  std::vector<link::Motion> flight() const;
  /// One window on flight().
  void window(const std::vector<RigidBody>& births = {});
  /// One window on these handbacks.
  void window_on(std::vector<link::Motion> predicted, const std::vector<RigidBody>& births = {},
                 const std::vector<BodyId>& solved = {}, bool again = false);
  void run(double seconds);
  /// From the next window on.
  void release(std::uint32_t joint) { released_.push_back(joint); }
  /// Says goodbye and goes. Throws Error (bad_exit) where the engine then ends with another status than 0.
  void end();

  const std::vector<link::Motion>& predicted() const { return predicted_; }  // of the last window
  const std::vector<link::State>& states() const { return states_; }         // moving ones by ascending id
  const RigidBody& body(BodyId id) const { return bodies_.at(id); }
  double time() const { return static_cast<double>(tick_) * scene_.window_s; }
  std::int64_t tick() const { return tick_; }

  double kinetic_energy() const;
  /// Of the last handbacks: the difference is what the engine did.
  double predicted_energy() const;
  Vec3 momentum() const;
  /// About a fixed point: of the paths and of the spins.
  Vec3 angular_momentum(const Vec3& about) const;
  Vec3 centre_of_mass() const;

 private:
  void take(const std::vector<link::State>& states);

  EngineProcess process_;
  Scene scene_;
  std::unique_ptr<link::RemoteRigid> link_;  // none after end()
  link::EngineInfo peer_;
  std::map<BodyId, RigidBody> bodies_;
  std::vector<link::Motion> predicted_;
  std::vector<link::State> states_;
  std::vector<std::uint32_t> released_;  // joints
  std::int64_t tick_ = 0;
  bool over_ = false;
};

/// A channel to the engine that waits for no reply longer than a minute.
std::unique_ptr<link::Transport> open_channel(const std::string& endpoint);

/// A window of free flight for each moving body.
std::vector<link::Motion> fly(const std::map<BodyId, RigidBody>& bodies, const Vec3& gravity, double window_s);

bool same_bits(const BodyMotion& a, const BodyMotion& b);
/// Largest deviation of a pose: of position relative to `size` or |b|, whichever is larger; of turn [rad].
double pose_error(const BodyMotion& a, const BodyMotion& b, double size_m);
/// Largest relative deviation of velocity and angular momentum.
double velocity_error(const BodyMotion& a, const BodyMotion& b);

}  // namespace sunder::conformance
