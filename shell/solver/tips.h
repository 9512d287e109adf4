#pragma once
// Cracks that find their own way: nucleation by strength, growth at tips by fracture energy.
// The rules and what is known of them: shell/README.md "How cracks run".
#include "shell/solver/interlock.h"

namespace sunder::shell {

struct CrackRules {
  double tip_radius = 0.0;          // a tip averages stress over this half disc [m]
  double advance = 0.0;             // length of a new edge [m]
  double speed_limit = 0.0;         // [m/s]
  double tip_strength = 0.0;        // mean stress ahead at which a tip runs, stretching [Pa]
  double tip_bending_strength = 0;  // the same on the surface, bending [Pa]
  double branch_ratio = 1.5;        // of the drive at which a tip branches: twice the energy release at sqrt 2
  double branch_angle = 0.49;       // of each arm [rad]
  double branch_spacing = 0.0;      // run before the next branch [m]
  double tip_clearance = 0.0;       // no nucleation or branch so near another tip [m]
  double parallel_clearance = 0.0;  // no nucleation so near a nearly parallel crack [m]
  double join = 0.0;                // a tip so near another crack or the border runs into it [m]
  double turn = 0.0;                // largest change of direction per edge [rad]
  double star_ratio = 0.6;          // principal stresses nearer than this start a star
  int star_arms = 3;
  int nucleations_per_step = 2;
  InterlockLaw faces;  // of fresh cracks
  bool interlock = true;
};

CrackRules make_crack_rules(const ShellModel& model, double tip_radius);

/// Substeps between two looks at the cracks: a tip at full speed is seen twice on its way along an edge.
int crack_interval(const CrackRules& rules, double dt);

/// Nucleation and growth over the last `dt` seconds. `random` is advanced only where a star takes a random phase.
/// Returns the number of edges inserted.
int grow_cracks(const ShellModel& model, ShellState& state, const CrackRules& rules, double time, double dt,
                std::uint64_t& random);

}  // namespace sunder::shell
