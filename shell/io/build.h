#pragma once
// Builds the model of a run from a scene: shells, bodies, contact coefficients.
#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "coupler/core/body.h"
#include "coupler/scene/load.h"
#include "shell/contact/proxy.h"
#include "shell/geometry/seams.h"
#include "shell/io/probes.h"
#include "shell/io/shell_setup.h"
#include "shell/soft/soft_bodies.h"
#include "shell/solver/stepping/mass_scaling.h"

namespace sunder::shell {

/// Largest number of substeps of a window.
constexpr double kMostSubsteps = 1e6;

/// How the shell shares a window with the rigid side (scene.proto, Coupling).
struct CouplingRules {
  enum class Scheme { kProxy, kExported, kIterated, kStaggered, kLagged };
  Scheme scheme = Scheme::kProxy;
  double export_above = 3.0;  // bodies with a larger stiffness ratio, the sum of k H^2 / M, are exported [-]
  int iterations = 8;
  double tolerance = 0.0;  // energy residual of a window [share of the largest energy]; 0: windows keep their length
  int ticks = 1;           // ticks of a window of full length
};

/// Limits of a joint. It is released when the first of them is reached.
struct JointBreak {
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  double time = kNever, angle = kNever, extension = kNever;  // [s], [rad], [m]
  bool can() const { return std::min({time, angle, extension}) < kNever; }
};

/// Everything that a run needs from a scene, in plain types.
struct RunSetup {
  std::string name;
  double end_time = 0.0, window = 0.0, settle_window = 0.0, safety = 0.8;  // [s], [-]
  double tick = 0.0;         // all windows are whole multiples of a tick [s]
  int steps = 0;             // equilibria in a scene where nothing moves; 0: shells move
  double time_step = 0.0;    // substep that the scene asks for [s]; 0: `safety` times the stable step
  bool local_steps = false;  // shells may evaluate their forces at every n-th substep (run/local_steps.h)
  double frame_interval = 0.0, shell_frame_interval = 0.0;
  std::vector<Probe> probes;
  bool thick_shells = false;         // frames have shells with their thickness too
  FieldSet fields;                   // arrays of frames that the scene asks for
  double probe_interval = 0.0;       // [s]
  double checkpoint_interval = 0.0;  // [s]; 0: none
  double last_change = 0.0;          // time of the last change of a load or support [s]
  double quiet_time = 0.0, quiet_growth = 0.0, latest_freeze = 0.0;
  Vec3 gravity = Vec3::Zero();
  std::vector<ShellSetup> shells;
  std::vector<SoftSetup> soft;
  Stitches stitches;                       // seams between the shells
  std::vector<std::string> touching;       // warnings of meshes that touch themselves in points
  std::vector<std::string> unit_warnings;  // values that look as if they were given in another unit
  bool shells_meet = false;                // shells may touch one another, or a shell itself
  double fibre_spacing = 0.0;  // spacing of the fibres' grid [m]; 0: no shell has fibres that could touch others
  std::uint64_t seed = 0;
  std::vector<RigidBody> bodies;
  std::vector<std::shared_ptr<const DrivenMotion>> driven;  // of each body; null: impulses move it. Empty: of none
  std::vector<Joint> joints;
  std::vector<JointBreak> breaks;  // of each joint
  CouplingRules coupling;
  std::vector<ContactLaw> laws;
  std::optional<MassScaling> mass_scaling;  // what it did; the models have the masses

  /// The copy of body i for the shells.
  Proxy proxy(std::size_t i) const { return Proxy(bodies[i], i < driven.size() ? driven[i] : nullptr); }
  /// Least thickness of the shells [m]; 0 without shells.
  double thickness() const;
  std::vector<const ShellModel*> models() const {
    std::vector<const ShellModel*> out;
    for (const ShellSetup& s : shells) out.push_back(&s.model);
    return out;
  }
  bool can_crack() const {
    return std::any_of(shells.begin(), shells.end(), [](const ShellSetup& s) { return s.can_crack(); });
  }
};

/// Builds the setup of a run. Throws Error at the scene's line and field where something is wrong.
RunSetup build(const scene::LoadedScene& scene);

}  // namespace sunder::shell
