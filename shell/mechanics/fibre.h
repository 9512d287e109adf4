#pragma once
// A fibre through half of a shell's thickness: strain by shear and compression, energy, stress, and slip (Jiang, Gast,
// Teran 2017; Guo et al. 2018; type-III particles of the paper).
//
// The director a3 is the normal n at rest, of length 1. Its components in the frame of the surface are
// a = Q^T a3 = (r13, r23, r33), Q = (q1, q2, n), so a rotation of shell and fibre together does not change them.
//   da/dt = Q^T (L - W) Q a,  L the velocity gradient that layers share, W the spin of the frame.
//
// Shear and pressure may damage a fibre (own derivation, after eq. 9 of the paper). With t = gamma |(r13, r23)|,
// p = k (1 - r33)^2 and the strengths t_f and p_f, both times a factor of the place:
//   q = max(t / t_f, p / p_f),  c = (1 + H) (1 - 1 / q) for q > 1, at most 1, else 0
//   psi' = (1 - c) gamma/2 (r13^2 + r23^2) + k/3 (1 - r33)^3
// So damage takes the shear stress, and pressure is borne as before. H = brittleness(t_f, gamma, G_f, l): shear takes
// t_f^2 (1 + H) / (2 gamma H) = G_f / l per volume.
#include <algorithm>
#include <cmath>
#include <limits>

#include "coupler/core/vec.h"

namespace sunder::shell {

struct FibreLaw {
  double compression = 0.0;  // k [Pa]; 0: the shell has no fibres
  double shear = 0.0;        // gamma [Pa]
  double friction = 0.0;     // c_f [-]
  // Of damage, at a factor of 1.
  double shear_strength = std::numeric_limits<double>::infinity();     // t_f [Pa]
  double crushing_strength = std::numeric_limits<double>::infinity();  // p_f [Pa]
  double brittleness = 0.0;                                            // H [-]; 0: fibres are not damaged

  bool breaks() const { return brittleness > 0.0; }
};

/// Shear stress at which shear alone has damaged a fibre fully, at a factor of 1 [Pa].
inline double complete_shear(const FibreLaw& law) {
  return law.shear_strength * (1.0 + law.brittleness) / law.brittleness;
}

/// Damage of a fibre, `least` to 1, in the precision in which it is stored. `factor` is that of the strengths.
inline float fibre_damage(const FibreLaw& law, const Vec3& a, double factor, float least) {
  if (a.z() > 1.0) return least;
  const double shear = law.shear * std::hypot(a.x(), a.y()), short_by = 1.0 - a.z();
  const double pressure = law.compression * short_by * short_by;
  const double q = std::max(shear / law.shear_strength, pressure / law.crushing_strength) / factor;
  if (q <= 1.0) return least;
  return std::max(least, static_cast<float>(std::min(1.0, (1.0 + law.brittleness) * (1.0 - 1.0 / q))));
}

/// psi = (1 - c) gamma/2 (r13^2 + r23^2) + k/3 (1 - r33)^3 [J/m^3]; the last term is zero for r33 > 1.
inline double fibre_energy(const FibreLaw& law, const Vec3& a, double c = 0.0) {
  const double short_by = std::max(0.0, 1.0 - a.z());
  return 0.5 * (1.0 - c) * law.shear * (a.x() * a.x() + a.y() * a.y()) +
         law.compression / 3.0 * short_by * short_by * short_by;
}

/// d psi / d a at fixed c [Pa].
inline Vec3 fibre_stress(const FibreLaw& law, const Vec3& a, double c = 0.0) {
  const double short_by = std::max(0.0, 1.0 - a.z()), shear = (1.0 - c) * law.shear;
  return {shear * a.x(), shear * a.y(), -law.compression * short_by * short_by};
}

/// Energy per volume that a change of damage from `before` to `now` takes, as the fibre goes from a to b [J/m^3]. It is
/// the work of the mean of both stresses less the change of psi, exactly.
inline double damage_energy(const FibreLaw& law, double before, double now, const Vec3& a, const Vec3& b) {
  return 0.5 * law.shear * (now - before) * (a.x() * b.x() + a.y() * b.y());
}

/// The fibre after slip at fixed damage c. Layers that separate exert no stress: for r33 > 1 it is (0, 0, 1). Otherwise
/// shear is scaled back to Coulomb's cone (1 - c) gamma |(r13, r23)| <= c_f k (1 - r33)^2. The energy does not grow.
/// A fully damaged fibre has no shear stress. It keeps as much shear as completes its damage, so layers may slide far.
inline Vec3 fibre_return(const FibreLaw& law, const Vec3& a, double c = 0.0, double factor = 1.0) {
  constexpr double kPast = 1.0 + 1e-6;  // keeps c at 1 despite round-off
  if (a.z() > 1.0) return Vec3::UnitZ();
  const double shear = law.shear * std::hypot(a.x(), a.y()), short_by = 1.0 - a.z();
  const double cone = law.friction * law.compression * short_by * short_by;
  const double most = c < 1.0 ? cone / (1.0 - c) : kPast * factor * complete_shear(law);
  if (shear <= most) return a;
  return {a.x() * (most / shear), a.y() * (most / shear), a.z()};
}

}  // namespace sunder::shell
