#pragma once
// A fibre through half of a shell's thickness: strain by shear and compression, energy, stress, and slip (Jiang, Gast,
// Teran 2017; Guo et al. 2018; type-III particles of the paper).
//
// The director a3 is the normal n at rest, of length 1. Its components in the frame of the surface are
// a = Q^T a3 = (r13, r23, r33), Q = (q1, q2, n), so a rotation of shell and fibre together does not change them.
//   da/dt = Q^T (L - W) Q a,  L the velocity gradient that layers share, W the spin of the frame.
#include <algorithm>
#include <cmath>

#include "coupler/core/vec.h"

namespace sunder::shell {

struct FibreLaw {
  double compression = 0.0;  // k [Pa]; 0: the shell has no fibres
  double shear = 0.0;        // gamma [Pa]
  double friction = 0.0;     // c_f [-]
};

/// psi = gamma/2 (r13^2 + r23^2) + k/3 (1 - r33)^3 [J/m^3]; the last term is zero for r33 > 1.
inline double fibre_energy(const FibreLaw& law, const Vec3& a) {
  const double short_by = std::max(0.0, 1.0 - a.z());
  return 0.5 * law.shear * (a.x() * a.x() + a.y() * a.y()) + law.compression / 3.0 * short_by * short_by * short_by;
}

/// d psi / d a [Pa].
inline Vec3 fibre_stress(const FibreLaw& law, const Vec3& a) {
  const double short_by = std::max(0.0, 1.0 - a.z());
  return {law.shear * a.x(), law.shear * a.y(), -law.compression * short_by * short_by};
}

/// The fibre after slip. Layers that separate exert no stress: for r33 > 1 it is (0, 0, 1). Otherwise shear is scaled
/// back to Coulomb's cone gamma |(r13, r23)| <= c_f k (1 - r33)^2. The energy does not grow.
inline Vec3 fibre_return(const FibreLaw& law, const Vec3& a) {
  if (a.z() > 1.0) return Vec3::UnitZ();
  const double shear = law.shear * std::hypot(a.x(), a.y()), short_by = 1.0 - a.z();
  const double most = law.friction * law.compression * short_by * short_by;
  if (shear <= most) return a;
  return {a.x() * (most / shear), a.y() * (most / shear), a.z()};
}

}  // namespace sunder::shell
