#pragma once
// A session with the engine in which this side plays the shell process. Its copies of the bodies fly freely through
// each window and give the predicted states.
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

/// One session with its bodies.
class Play {
 public:
  /// Starts the engine and sends Hello and Load. Throws Error as link::RigidLink does.
  Play(const Target& target, Scene scene);
  ~Play();
  /// The scene with the bodies as they are now, for another engine that continues from here.
  Scene now() const;

  const link::EngineInfo& peer() const { return peer_; }
  link::RigidLink& link() { return *link_; }

  /// Predicted state of each moving body: free flight for a window.
  std::vector<link::Motion> flight() const;
  /// One window with flight() as predicted states.
  void window(const std::vector<RigidBody>& births = {});
  /// One window with these predicted states.
  void window_on(std::vector<link::Motion> predicted, const std::vector<RigidBody>& births = {},
                 const std::vector<BodyId>& solved = {}, bool again = false);
  void run(double seconds);
  /// Releases a joint from the next window on.
  void release(std::uint32_t joint) { released_.push_back(joint); }
  /// Sends Bye and closes. Throws Error (bad_exit) where the engine does not end with status 0.
  void end();

  const std::vector<link::Motion>& predicted() const { return predicted_; }  // of the last window
  const std::vector<link::State>& states() const { return states_; }         // moving ones by ascending id
  const RigidBody& body(BodyId id) const { return bodies_.at(id); }
  double time() const { return static_cast<double>(tick_) * scene_.window_s; }
  std::int64_t tick() const { return tick_; }

  double kinetic_energy() const;  // [J]
  /// Kinetic energy of the last predicted states [J]. The difference from kinetic_energy() is the engine's.
  double predicted_energy() const;
  Vec3 momentum() const;
  /// Angular momentum about a fixed point [kg m^2/s], of translation and rotation.
  Vec3 angular_momentum(const Vec3& about) const;
  Vec3 centre_of_mass() const;

 private:
  void take(const std::vector<link::State>& states);

  EngineProcess process_;
  Scene scene_;
  std::unique_ptr<link::RemoteRigid> link_;  // null after end()
  link::EngineInfo peer_;
  std::map<BodyId, RigidBody> bodies_;
  std::vector<link::Motion> predicted_;
  std::vector<link::State> states_;
  std::vector<std::uint32_t> released_;  // joints
  std::int64_t tick_ = 0;
  bool over_ = false;
};

/// A channel to the engine that waits a minute at most for a reply.
std::unique_ptr<link::Transport> open_channel(const std::string& endpoint);

/// Motion of each moving body after a window of free flight.
std::vector<link::Motion> fly(const std::map<BodyId, RigidBody>& bodies, const Vec3& gravity, double window_s);

bool same_bits(const BodyMotion& a, const BodyMotion& b);
/// Larger one of two deviations: of the position, relative to the larger of `size_m` and |b|, and of the turn [rad].
double pose_error(const BodyMotion& a, const BodyMotion& b, double size_m);
/// Larger one of the relative deviations of velocity and angular momentum.
double velocity_error(const BodyMotion& a, const BodyMotion& b);

}  // namespace sunder::conformance
