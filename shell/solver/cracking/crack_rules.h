#pragma once
// The constants by which cracks start and run; what is known of them: shell/README.md "How cracks run".
#include "shell/solver/interlock.h"

namespace sunder::shell {

struct CrackRules {
  double tip_radius = 0.0;          // a tip averages stress within it [m]
  double advance = 0.0;             // length of a new edge [m]
  double rayleigh = 0.0;            // no crack is faster [m/s]
  double tip_strength = 0.0;        // mean stress ahead at which a tip runs, stretching [Pa]
  double tip_bending_strength = 0;  // the same on the surface, bending [Pa]
  double process_length = 0.0;      // E G / strength^2: so far ahead of a tip the strength means nothing [m]
  double branch_ratio = 1.5;        // of the drive at which a tip branches: twice the energy release at sqrt 2
  double branch_angle = 0.49;       // of each arm [rad]
  double branch_spacing = 0.0;      // run before the next branch [m]
  double branch_clearance = 0.0;    // no branch so near another tip [m]
  double tip_clearance = 0.0;       // no nucleation so near a tip [m]
  double parallel_clearance = 0.0;  // no nucleation so near a nearly parallel crack [m]
  double join = 0.0;                // a tip so near another crack or the border runs into it [m]
  double turn = 0.0;                // largest change of direction per edge [rad]
  double alike = 0.8;               // principal stresses nearer than this leave the direction to chance
  int nucleations_per_step = 2;
  InterlockLaw faces;  // of fresh cracks
  bool interlock = true;
  int threads = 1;  // that evaluate what an edge would do; results are the same for any number
};

/// `tip_radius` 0: the default.
CrackRules make_crack_rules(const ShellModel& model, double tip_radius);

/// Substeps between two looks at the cracks: a tip at full speed is seen twice on its way along an edge.
int crack_interval(const CrackRules& rules, double dt);

/// Uniform in [0, 1); splitmix64.
double uniform(std::uint64_t& state);

}  // namespace sunder::shell
