#pragma once
// The rigid side as the shell process sees it: an engine in this process, a session, or a recording.
#include <cstdint>
#include <string>
#include <vector>

#include "coupler/link/engine.h"

namespace sunder::link {

/// Bodies, laws and joints that the engine gets before the first window.
struct World {
  std::vector<RigidBody> bodies;  // by ascending id
  std::vector<ContactLaw> laws;
  std::vector<Joint> joints;
  std::int64_t tick = 0;      // of the first window
  bool keep_windows = false;  // the engine must be able to take a window again
  double thickness = 0.0;     // of the thinnest shell [m]; 0: not known
};

/// One window of the engine.
struct WindowTask {
  std::int64_t tick = 0;  // at the start of the window
  int ticks = 1;
  double window_s = 0.0;                  // length of the whole window [s]
  std::vector<Motion> predicted;          // predicted states of all bodies that are not static, by id
  std::vector<BodyId> solved;             // bodies whose contacts and joints the shell process has solved, by id
  std::vector<RigidBody> births{};        // bodies added at the end of the window
  bool again = false;                     // replaces the last window
  std::vector<std::uint32_t> released{};  // all joints released so far
};

/// The rigid side of a run. Every call throws Error: peer_lost, bad_message, or the engine's error.
class RigidLink {
 public:
  virtual ~RigidLink() = default;
  /// The engine on the other side.
  virtual const EngineInfo& peer() const = 0;
  /// Loads the world, once and first. Returns the states of bodies that are not static, by id.
  virtual std::vector<State> load(const World& world) = 0;
  /// Right after load: takes what `save` returned for the same bodies and motions.
  virtual void restore(const std::string& caches) = 0;
  /// Contacts that `bodies` may have in the window from `tick` on, as Engine::rows.
  virtual std::vector<ContactRow> rows(std::int64_t tick, double window_s, const std::vector<Motion>& motions,
                                       const std::vector<BodyId>& bodies) = 0;
  /// Takes one window. Returns the state of every body that is not static, newborn ones included, by id.
  virtual std::vector<State> window(const WindowTask& task) = 0;
  /// Adds bodies between two windows. Returns the states of those that are not static.
  virtual std::vector<State> add_bodies(const std::vector<RigidBody>& bodies) = 0;
  /// The engine's saved state, for a checkpoint (Engine::save).
  virtual std::string save() = 0;
  /// Ends the session.
  virtual void bye() = 0;
  /// Ends the session with an error and tells the other side why.
  virtual void abort(const std::string& kind, const std::string& message) noexcept = 0;
  /// Throws Error where the other side is gone; returns at once.
  virtual void check_peer() = 0;
};

}  // namespace sunder::link
