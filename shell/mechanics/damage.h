#pragma once
// Rankine damage of a layer (paper 5.1, eq. 9): the largest principal Cauchy stress sets the damage, which
// weakens tension and leaves compression. It follows the present stress and heals, or stays at its maximum over time.
#include "shell/mechanics/plane_stress.h"

namespace sunder::shell {

/// Brittleness H = Hbar l / (1 - Hbar l) of eq. 9, Hbar = strength^2 / (2 E G_f) [1/m], l the width over
/// which damage localises [m]. Not positive where Hbar l >= 1: the grid does not resolve the softening.
inline double brittleness(double strength, double youngs_modulus, double fracture_energy, double width) {
  const double product = strength * strength * width / (2.0 * youngs_modulus * fracture_energy);
  return product < 1.0 ? product / (1.0 - product) : -1.0;
}

template <class T>
inline T largest(const T& a, const T& b) {
  return select(a > b, a, b);
}

/// Weakens S (second Piola-Kirchhoff, contravariant) at metric C and volume ratio J = J0 lambda3 in place
/// and returns the damage, 0 to 1 by eq. 9. With the mixed Cauchy stress sigma = S C / J of principal values s1 >= s2,
/// sigma' = sigma - c (s1+ P1 + s2+ P2). In two dimensions the positive part is a I + b sigma, b = (s1+ - s2+) /
/// (s1 - s2), a = s1+ - b s1. All here is J times that, and the strength with it: that leaves one division, which is
/// what costs most. Where both are equal b is any number, and a makes up for it.
/// Where it does not heal it is not less than `least`.
template <class T, bool kHeals = true>
[[gnu::always_inline]] inline T weaken(Sym2<T>& s, const Sym2<T>& c, const T& volume, const T& strength, double h,
                                       const T& least = T{}) {
  constexpr double kApart = 1e-20;  // of the strength: so close to one another b times the difference is no error
  const T none = splat<T>(0.0), limit = strength * volume;
  const T mean = 0.5 * (s.c11 * c.c11 + s.c22 * c.c22) + s.c12 * c.c12;
  const T det_c = determinant(c);
  const T radius = square_root(largest<T>(mean * mean - determinant(s) * det_c, none));
  const T high = mean + radius, low = mean - radius;
  const T over = largest<T>(high, limit), apart = largest<T>(2.0 * radius, kApart * limit);
  const T inverse = 1.0 / (over * apart * det_c);
  const T full = (1.0 + h) * ((over - limit) * (inverse * apart * det_c));  // exactly zero where nothing is damaged
  T damage = select(full < 1.0, full, splat<T>(1.0));
  if constexpr (!kHeals) damage = largest<T>(damage, least);
  const T tension = largest<T>(high, none);
  const T b = (tension - largest<T>(low, none)) * (inverse * over * det_c), a = tension - b * high;
  const T keep = 1.0 - damage * b;
  const T metric = damage * a * (inverse * over * apart);  // times the adjugate of C: J C^-1
  s = {keep * s.c11 - metric * c.c22, keep * s.c22 - metric * c.c11, keep * s.c12 + metric * c.c12};
  return damage;
}

}  // namespace sunder::shell
