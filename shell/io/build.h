#pragma once
// Scene -> model: shells, bodies, contact coefficients.
#include <algorithm>
#include <limits>
#include <vector>

#include "coupler/core/body.h"
#include "coupler/scene/load.h"
#include "shell/geometry/seams.h"
#include "shell/io/probes.h"
#include "shell/io/shell_setup.h"
#include "shell/soft/soft_bodies.h"

namespace sunder::shell {

/// Substeps that a window may take.
constexpr double kMostSubsteps = 1e6;

/// How a window is shared with the rigid side (scene.proto, Coupling).
struct CouplingRules {
  enum class Scheme { kProxy, kExported, kIterated, kStaggered, kLagged };
  Scheme scheme = Scheme::kProxy;
  double export_above = 3.0;  // sum of k H^2 / M [-]
  int iterations = 8;
  double tolerance = 0.0;  // energy residual of a window, of the most energy there was; 0: windows keep their length
  int ticks = 1;           // of a window of full length
};

/// When a joint lets go: what comes first.
struct JointBreak {
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  double time = kNever, angle = kNever, extension = kNever;  // [s], [rad], [m]
  bool can() const { return std::min({time, angle, extension}) < kNever; }
};

/// All that a run needs from a scene, in plain types.
struct RunSetup {
  std::string name;
  double end_time = 0.0, window = 0.0, settle_window = 0.0, safety = 0.8;  // [s], [-]
  double tick = 0.0;                                                       // all windows are whole multiples of it [s]
  double time_step = 0.0;  // of a substep, as the scene asks for it [s]; 0: `safety` times the stable one
  double frame_interval = 0.0, shell_frame_interval = 0.0;
  std::vector<Probe> probes;
  double probe_interval = 0.0;       // [s]
  double checkpoint_interval = 0.0;  // [s]; 0: none
  double last_change = 0.0;          // when the last load or support has stopped changing [s]
  double quiet_time = 0.0, quiet_growth = 0.0, latest_freeze = 0.0;
  Vec3 gravity = Vec3::Zero();
  std::vector<ShellSetup> shells;
  std::vector<SoftSetup> soft;
  Stitches stitches;           // between them
  bool shells_meet = false;    // contact between them, or of one with itself
  double fibre_spacing = 0.0;  // of their grid [m]; 0: no shell has fibres that could touch others
  std::uint64_t seed = 0;
  std::vector<RigidBody> bodies;
  std::vector<Joint> joints;
  std::vector<JointBreak> breaks;  // of each
  CouplingRules coupling;
  std::vector<ContactLaw> laws;

  /// Of the thinnest shell; 0 where there is none [m].
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

RunSetup build(const scene::LoadedScene& scene);

}  // namespace sunder::shell
