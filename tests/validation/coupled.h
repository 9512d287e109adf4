#pragma once
// A ball, two balls or a hinged rod under a plate, with the engine in the same process, observed in every window.
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "coupler/core/body.h"
#include "coupler/link/engine.h"
#include "shell/contact/proxy.h"

namespace sunder::validation {

enum class Hold { kFree, kFloor, kBody, kHinge };
constexpr const char* kHoldNames[] = {"free", "floor", "body", "hinge"};

struct Coupled {
  Hold hold = Hold::kFree;
  double ratio = 1.0;  // mass of each body, as a multiple of the plate's
  int substeps = 1;    // per window
  int windows = 1000;
  std::string scheme = "PROXY", engine = "bullet";  // the scheme, then any other fields of `coupling`
  bool elastic = true;   // Hertz contact, which conserves energy; otherwise impulses with friction, and a spin
  bool resting = false;  // gravity presses the free body on the plate; otherwise it is thrown
  std::string more;      // more of the scene, as text
};

struct Watched {
  std::string failure;                                             // empty: the run reached its end
  double start_energy = 0.0, most_energy = 0.0, end_energy = 0.0;  // kinetic and elastic [J]
  double hardest = 0.0;                                            // largest k H^2 / M that was measured
  double ledger = 0.0;
  int exported = 0;
  std::vector<BodyMotion> track;  // motion of the first body after every window
  double seconds = 0.0;
  double gain() const { return most_energy / start_energy - 1.0; }
};

using Watch = std::function<void(double time, double energy, const std::vector<const RigidBody*>&)>;
using Tamper = std::function<void(std::int64_t window, std::vector<shell::Proxy>&)>;

/// Returns the scene as text.
std::string coupled_text(const Coupled& what);
/// Returns the length of a substep of the plate [s].
double coupled_substep();
Watched run_coupled(const Coupled& what, const Tamper& tamper = {});

struct WatchedRun {
  double hardest = 0.0;
  int exported = 0;
  std::string summary;  // run.json
};

/// Runs a scene's text in this process. Returns the error message, or an empty text. `watch` receives time [s], kinetic
/// and elastic energy [J] and the bodies after every window. `tamper` receives the window and the bodies before their
/// ledger is checked. `files`, by name, are written beside the scene.
std::string run_text(const std::string& scene, const std::string& engine, const Watch& watch, WatchedRun* end = nullptr,
                     const Tamper& tamper = {}, const std::map<std::string, std::string>& files = {});
/// The same with the caller's engine.
std::string run_text(const std::string& scene, link::Engine& engine, const Watch& watch, WatchedRun* end = nullptr,
                     const Tamper& tamper = {}, const std::map<std::string, std::string>& files = {});

}  // namespace sunder::validation
