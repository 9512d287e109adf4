#pragma once
// The shell's view of the rigid side, whatever is between: an engine in this process, a session, a recording.
#include <cstdint>
#include <string>
#include <vector>

#include "coupler/link/engine.h"

namespace sunder::link {

/// What the engine gets before the first window.
struct World {
  std::vector<RigidBody> bodies;  // by ascending id
  std::vector<ContactLaw> laws;
  std::vector<Joint> joints;
  std::int64_t tick = 0;      // of the first window
  bool keep_windows = false;  // windows will be repeated
  double thickness = 0.0;     // of the thinnest shell [m]; 0: not known
};

struct WindowTask {
  std::int64_t tick = 0;  // at the start
  int ticks = 1;
  double window_s = 0.0;                  // length of the whole window
  std::vector<Motion> handbacks;          // of every body that is not static, by id
  std::vector<BodyId> solved;             // whose contacts and joints are solved already, by id
  std::vector<RigidBody> births{};        // that join at the end
  bool again = false;                     // in place of the last window
  std::vector<std::uint32_t> released{};  // all joints that have let go so far
};

/// Every call throws Error: peer_lost, bad_message, or what the engine says.
class RigidLink {
 public:
  virtual ~RigidLink() = default;
  virtual const EngineInfo& peer() const = 0;
  virtual std::vector<State> load(const World& world) = 0;
  /// Right after load: what `save` returned when bodies were as they were loaded.
  virtual void restore(const std::string& caches) = 0;
  virtual std::vector<ContactRow> rows(std::int64_t tick, double window_s, const std::vector<Motion>& motions,
                                       const std::vector<BodyId>& bodies) = 0;
  /// State of every body that is not static, newborn ones included, by id.
  virtual std::vector<State> window(const WindowTask& task) = 0;
  /// Between two windows; returns their states.
  virtual std::vector<State> add_bodies(const std::vector<RigidBody>& bodies) = 0;
  virtual std::string save() = 0;
  virtual void bye() = 0;
  /// Tells the other side why the session ends.
  virtual void abort(const std::string& kind, const std::string& message) noexcept = 0;
  /// Throws where the other side has gone; returns at once.
  virtual void check_peer() = 0;
};

}  // namespace sunder::link
