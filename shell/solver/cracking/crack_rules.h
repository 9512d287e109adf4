#pragma once
// By which rules a shell cracks: its mode, and the constants of each criterion in the units of its model. The constants
// themselves, with their sources, are in shell/fracture/constants.h.
#include <cstdint>
#include <vector>

#include "shell/fracture/calibrated_constants.h"
#include "shell/solver/interlock.h"

namespace sunder::shell {

/// How tips run and new cracks start.
struct CrackRules {
  double tip_radius = 0.0;             // R, radius of the mean stress ahead of a tip [m]
  double advance = 0.0;                // length of a new edge [m]
  double rayleigh = 0.0;               // no crack is faster [m/s]
  double tip_strength = 0.0;           // mean stress ahead at which a tip runs, stretched [Pa]
  double tip_bending_strength = 0.0;   // the same on the surface, bent [Pa]
  double process_length = 0.0;         // E G_f / strength^2: no crack starts so near a tip [m]
  double branch_ratio = 1.0;           // drive above which a tip divides [-]
  double branch_angle = kBranchAngle;  // of each arm [rad]
  double branch_clearance = 0.0;       // no division so near another tip [m]
  double tip_clearance = 0.0;          // no new crack so near ahead of a tip [m]
  double parallel_clearance = 0.0;     // no new crack so near a nearly parallel crack [m]
  double join = 0.0;                   // a tip so near another crack or the border ends on it [m]
  double turn = kMostTurn;             // largest change of direction per edge [rad]
  double to_diagonal = kToDiagonal;    // turn by the lattice that is taken off [rad]
  double alike = kAlike;               // principal stresses nearer than this leave the direction to chance [-]
  InterlockLaw faces;                  // of fresh cracks
  bool interlock = true;
  int threads = 1;  // that evaluate what an edge would do; results are the same for any number
};

/// How damage weakens a shell, and how cracks follow from it.
struct DamageRules {
  double brittleness = 0.0;                // H of paper eq. 9
  bool heals = true;                       // as the stress falls
  bool extract = true;                     // cracks, where damage is complete
  bool faces = false;                      // of its cracks bear on each other
  double spent_beside = kSpentBeside;      // [spacings]
  double shortest_line = kShortestLine;    // [spacings]
  double spur = kSpur;                     // [spacings]
  double unhealed = kUnhealed;             // [share]
  double damaged_reach = kDamagedReach;    // [spacings]
  double through_damage = kThroughDamage;  // [share]
  double broad_damage = kBroadDamage;      // [share]
  double turn = kDamageTurn;               // [rad]
  double torn_stress = kTornStress;        // [stress of complete damage]
};

/// A segment of a cut that lies on an edge of the patch.
struct EdgeCut {
  int edge = 0;                 // EdgeBit
  double from = 0.0, to = 0.0;  // shares of the edge, `from` the smaller
};

/// A cut that the scene prescribes.
struct PrescribedCut {
  std::vector<std::vector<Vec2>> lines;  // each closed where the last point is exactly the first
  std::vector<EdgeCut> on_edges;
  double time = 0.0;     // [s]
  int number = 0;        // of the cut in the scene; one that grows is several of these, in their order
  bool goes_on = false;  // another one goes on at its end, which is not open
};

/// How cracks start and run by themselves.
enum class FractureMode {
  kNone,    // they do not
  kTips,    // they start by the strength and run at their tips by the fracture energy
  kDamage,  // they follow from damage
};

/// All that decides how a shell cracks. Which criteria are at work follows from it (criteria.h).
struct FractureRules {
  FractureMode mode = FractureMode::kNone;
  bool cut_faces = false;  // faces of prescribed cuts bear on each other
  // Of every mode but kNone: the interval between two looks is that of tips. `tips.faces` is of all modes.
  CrackRules tips{};
  DamageRules damage{};  // of kDamage
  std::vector<PrescribedCut> cuts{};

  bool tips_run() const { return mode == FractureMode::kTips; }
  bool damages() const { return mode == FractureMode::kDamage; }
};

/// `tip_radius` [m], 0: the default.
CrackRules make_crack_rules(const ShellModel& model, double tip_radius, const CalibratedConstants& calibrated = {});

/// Puts these constants in place of the rules' own.
void set_calibrated(DamageRules& rules, const CalibratedConstants& calibrated);

/// Substeps between two looks at the cracks: a tip at full speed is seen twice on its way along an edge.
int crack_interval(const CrackRules& rules, double dt);

/// Uniform in [0, 1); splitmix64.
double uniform(std::uint64_t& state);

}  // namespace sunder::shell
