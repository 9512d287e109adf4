#pragma once
// A fibre through half of a shell's thickness: how shear and compression strain it, what it bears, and where it slips
// (Jiang, Gast, Teran 2017; Guo et al. 2018; the paper's type-III particles).
//
// The director a3 (at rest the normal n, of length 1) is held by its components in the surface's own frame,
// a = Q^T a3 = (r13, r23, r33), Q = (q1, q2, n): turning shell and fibre together changes nothing. It follows
//   da/dt = Q^T (L - W) Q a,  L the gradient of the velocity that layers share, W the frame's spin.
#include <algorithm>
#include <cmath>

#include "coupler/core/vec.h"

namespace sunder::shell {

struct FibreLaw {
  double compression = 0.0;  // k [Pa]; 0: the shell has no fibres
  double shear = 0.0;        // gamma [Pa]
  double friction = 0.0;     // c_f [-]
};

/// psi = gamma/2 (r13^2 + r23^2) + k/3 (1 - r33)^3 below r33 = 1, without the last term beyond [J/m^3].
inline double fibre_energy(const FibreLaw& law, const Vec3& a) {
  const double short_by = std::max(0.0, 1.0 - a.z());
  return 0.5 * law.shear * (a.x() * a.x() + a.y() * a.y()) + law.compression / 3.0 * short_by * short_by * short_by;
}

/// d psi / d a [Pa].
inline Vec3 fibre_stress(const FibreLaw& law, const Vec3& a) {
  const double short_by = std::max(0.0, 1.0 - a.z());
  return {law.shear * a.x(), law.shear * a.y(), -law.compression * short_by * short_by};
}

/// Layers that part do not hold one another: r33 > 1 is (0, 0, 1). Else shear slips back to the cone
/// gamma |(r13, r23)| <= c_f k (1 - r33)^2, which is Coulomb's law. Never adds energy.
inline Vec3 fibre_return(const FibreLaw& law, const Vec3& a) {
  if (a.z() > 1.0) return Vec3::UnitZ();
  const double shear = law.shear * std::hypot(a.x(), a.y()), short_by = 1.0 - a.z();
  const double most = law.friction * law.compression * short_by * short_by;
  if (shear <= most) return a;
  return {a.x() * (most / shear), a.y() * (most / shear), a.z()};
}

}  // namespace sunder::shell
