#pragma once
// How fast a tip runs at an energy release, and what each area of its crack takes. A fast tip in a brittle solid leaves
// microbranches: from an onset on, it makes more surface for each area of crack (Sharon and Fineberg 1998). The energy
// for each area of real surface stays the material's.
//   Gamma / Gamma0 = 1 + k (beta - beta0)  above the onset beta0, 1 below;  beta = v / c_R
//   (1 - beta) g = Gamma / Gamma0          Freund's energy balance;  g = G / Gamma0
#include "shell/solver/model.h"

namespace sunder::shell {

/// Speed [c_R] of a tip whose energy release, as if it stood still, is `g` fracture energies. 0 up to g = 1. Below the
/// onset 1 - 1/g, above it (g - 1 + k beta0) / (g + k).
inline double tip_speed(const ShellMaterial& material, double g) {
  if (!(g > 1.0)) return 0.0;
  const double plain = 1.0 - 1.0 / g, k = material.toughening, onset = material.crack_speed_onset;
  if (k == 0.0 || plain <= onset) return plain;
  return (g - 1.0 + k * onset) / (g + k);
}

/// Fracture energy of a tip at `speed` [c_R], over that of one at rest.
inline double toughened(const ShellMaterial& material, double speed) {
  const double over = speed - material.crack_speed_onset;
  return over > 0.0 ? 1.0 + material.toughening * over : 1.0;
}

}  // namespace sunder::shell
