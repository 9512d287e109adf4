#include "shell/solver/cracking/crack_rules.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "shell/solver/cracking/tip_drive.h"

namespace sunder::shell {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kCrushing = 10.0;  // compressive over tensile strength of glass and ceramics, about
constexpr double kRadius = 2.0;     // spacings over which a tip averages

}  // namespace

CrackRules make_crack_rules(const ShellModel& m, double tip_radius) {
  const double l = m.spacing, e = m.material.youngs_modulus, g = m.material.fracture_energy;
  CrackRules r;
  r.tip_radius = tip_radius > 0.0 ? tip_radius : kRadius * l;
  r.advance = 0.75 * l;
  r.rayleigh = m.rayleigh_speed();
  const double toughness = std::sqrt(e * g / r.tip_radius);
  r.tip_strength = stretching_mean() * toughness;
  r.tip_bending_strength = bending_mean(m.material.poisson_ratio) * toughness;
  r.process_length = e * g / (m.material.strength * m.material.strength);
  r.branch_ratio = std::numbers::sqrt2, r.branch_angle = 28.0 * kDegree;
  r.branch_spacing = 8.0 * l, r.branch_clearance = 2.5 * l;
  r.tip_clearance = std::max({2.5 * l, m.thickness, r.process_length});
  r.parallel_clearance = std::max(2.5 * l, 2.0 * m.thickness);
  r.join = l;
  r.turn = 10.0 * kDegree;
  r.faces = {0.05 * m.thickness, kCrushing * m.material.strength};
  return r;
}

int crack_interval(const CrackRules& r, double dt) {
  return std::max(1, static_cast<int>(0.5 * r.advance / (r.rayleigh * dt)));
}

double uniform(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15ULL);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
}

}  // namespace sunder::shell
