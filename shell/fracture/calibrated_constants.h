#pragma once
// The calibrated constants of fracture as values, for a caller that asks what each of them does.
#include "shell/fracture/constants.h"

namespace sunder::shell {

/// All that are calibrated, as values that a caller may scale (`validate cracks --case sensitivity`). Its names are
/// those of the constants.
struct CalibratedConstants {
  double to_diagonal = kToDiagonal;
  double most_turn = kMostTurn;
  double flaw_spacing = kFlawSpacing;
  double cracked_step = kCrackedStep;
  double spent_beside = kSpentBeside;
  double shortest_line = kShortestLine;
  double spur = kSpur;
  double unhealed = kUnhealed;
  double damaged_reach = kDamagedReach;
  double through_damage = kThroughDamage;
  double broad_damage = kBroadDamage;
  double damage_turn = kDamageTurn;
  double torn_stress = kTornStress;
};

}  // namespace sunder::shell
