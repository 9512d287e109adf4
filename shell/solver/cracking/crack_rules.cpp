#include "shell/solver/cracking/crack_rules.h"

#include <algorithm>
#include <cmath>

#include "shell/solver/cracking/tip_drive.h"

namespace sunder::shell {

CrackRules make_crack_rules(const ShellModel& m, double tip_radius, const CalibratedConstants& calibrated) {
  const double l = m.spacing, e = m.material.youngs_modulus, g = m.material.fracture_energy;
  CrackRules r;
  r.tip_radius = tip_radius > 0.0 ? tip_radius : kTipRadius * l;
  r.advance = kEdgeLength * l;
  r.rayleigh = m.rayleigh_speed();
  const double toughness = std::sqrt(e * g / r.tip_radius);
  r.tip_strength = stretching_mean() * toughness;
  r.tip_bending_strength = bending_mean(m.material.poisson_ratio) * toughness;
  r.process_length = e * g / (m.material.strength * m.material.strength);
  r.branch_ratio = std::sqrt(m.material.branch_drive), r.branch_clearance = kClearance * l;
  r.tip_clearance = std::max({kClearance * l, m.largest_thickness(), r.process_length});
  r.parallel_clearance = std::max(kClearance * l, kParallelThickness * m.largest_thickness());
  r.join = kJoinReach * l;
  r.turn = calibrated.most_turn;
  r.to_diagonal = calibrated.to_diagonal;
  r.faces = {0.0, kInterlockOpening};
  return r;
}

void set_calibrated(DamageRules& r, const CalibratedConstants& c) {
  r.spent_beside = c.spent_beside, r.shortest_line = c.shortest_line, r.spur = c.spur, r.unhealed = c.unhealed;
  r.damaged_reach = c.damaged_reach, r.through_damage = c.through_damage, r.broad_damage = c.broad_damage;
  r.turn = c.damage_turn, r.torn_stress = c.torn_stress;
}

int crack_interval(const CrackRules& r, double dt) {
  return std::max(1, static_cast<int>(kLookShare * r.advance / (r.rayleigh * dt)));
}

double uniform(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15ULL);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
}

}  // namespace sunder::shell
