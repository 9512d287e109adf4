#pragma once
// The shell's side of a session: Hello, Load, Window..., Bye.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "coupler/core/body.h"
#include "coupler/link/channel.h"

namespace sunder::link {

struct Peer {
  std::string name, version;
  std::vector<std::string> capabilities;
};
struct State {
  BodyId id = 0;
  double mass = 0.0;
  BodyMotion motion;
};
struct Motion {
  BodyId id = 0;
  BodyMotion motion;
};

class RigidClient {
 public:
  RigidClient(const std::string& endpoint, const std::string& scene_hash);
  const Peer& peer() const { return peer_; }
  std::vector<State> load(const std::vector<RigidBody>& bodies, const std::vector<ContactLaw>& laws);
  /// Moves the bodies by `ticks`; `births` join at the end. Returns every moving body's state by id.
  std::vector<State> window(std::int64_t tick, int ticks, double window_s, const std::vector<Motion>& motions,
                            const std::vector<RigidBody>& births);
  void bye();
  /// Tells the peer why the session ends; never throws.
  void abort(const std::string& kind, const std::string& message) noexcept;
  void check_peer() { channel_.check_peer(); }

 private:
  Channel channel_;
  Peer peer_;
  std::uint64_t sequence_ = 0;
};

}  // namespace sunder::link
