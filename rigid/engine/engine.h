#pragma once
// What the rigid process asks of a rigid-body engine. Nothing outside this folder names an engine.
#include <memory>
#include <string>
#include <vector>

#include "coupler/core/body.h"

namespace sunder::rigid {

struct EngineInfo {
  std::string name, version;
  std::vector<std::string> capabilities;  // plain words, listed in rigid/README.md
};

/// Where the solver's copy of a body has come by itself at the end of a window: free flight, gravity
/// and contact with the shell included, contacts and joints between rigid bodies not.
struct Handback {
  BodyId id = 0;
  BodyMotion motion;
};

/// What the engine makes of a body.
struct EngineState {
  BodyId id = 0;
  double mass = 0.0;  // [kg], as the engine holds it
  BodyMotion motion;
};

class Engine {
 public:
  virtual ~Engine() = default;
  virtual EngineInfo info() const = 0;
  /// Throws Error (bad_body) where the engine cannot hold the shape.
  virtual void add(const RigidBody& body) = 0;
  virtual void set_contact_laws(const std::vector<ContactLaw>& laws) = 0;
  /// One window of `window_s` seconds (rigid/README.md "A window"): each body takes the window
  /// with the average velocity that leads to its handback pose, contacts are found and solved on
  /// that, and it ends on its handback velocity plus the change that the solver made; then a
  /// velocity-only solve at the new pose. One handback for each body that is not static, by id.
  virtual void advance(double window_s, const std::vector<Handback>& handbacks) = 0;
  /// Every body that is not static, by ascending id.
  virtual std::vector<EngineState> states() const = 0;
};

/// Names that make_engine takes.
std::vector<std::string> engine_names();
/// Throws Error (unknown_engine) with the names that there are.
std::unique_ptr<Engine> make_engine(const std::string& name);

}  // namespace sunder::rigid
