#pragma once
// A ball, two balls or a hinged rod under a plate, with the engine in the same process, watched window by window.
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
  double ratio = 1.0;  // mass of each body over the plate's
  int substeps = 1;    // a window
  int windows = 1000;
  std::string scheme = "PROXY", engine = "bullet";  // the scheme, and after it what else `coupling` has
  bool elastic = true;   // Hertz contact, whose energy tells; else impulses with friction, and a spin
  bool resting = false;  // free, and pressed on the plate by gravity instead of thrown
  std::string more;      // of the scene, as text
};

struct Watched {
  std::string failure;                                             // empty: ran to its end
  double start_energy = 0.0, most_energy = 0.0, end_energy = 0.0;  // kinetic and elastic [J]
  double hardest = 0.0;                                            // k H^2 / M that was measured
  double ledger = 0.0;
  int exported = 0;
  std::vector<BodyMotion> track;  // of the first body, after every window
  double seconds = 0.0;
  double gain() const { return most_energy / start_energy - 1.0; }
};

using Watch = std::function<void(double time, double energy, const std::vector<const RigidBody*>&)>;
using Tamper = std::function<void(std::int64_t window, std::vector<shell::Proxy>&)>;

/// The scene as text.
std::string coupled_text(const Coupled& what);
/// Length of a substep of the plate [s].
double coupled_substep();
Watched run_coupled(const Coupled& what, const Tamper& tamper = {});

struct WatchedRun {
  double hardest = 0.0;
  int exported = 0;
  std::string summary;  // run.json
};

/// Runs a scene's text in this process; returns what went wrong, or nothing. `watch` gets time [s], kinetic and elastic
/// energy [J] and the bodies after every window; `tamper` the window and the bodies before their ledger is checked.
/// `files`, by name, lie beside the scene.
std::string run_text(const std::string& scene, const std::string& engine, const Watch& watch, WatchedRun* end = nullptr,
                     const Tamper& tamper = {}, const std::map<std::string, std::string>& files = {});
/// The same with an engine that the caller holds.
std::string run_text(const std::string& scene, link::Engine& engine, const Watch& watch, WatchedRun* end = nullptr,
                     const Tamper& tamper = {}, const std::map<std::string, std::string>& files = {});

}  // namespace sunder::validation
