#pragma once
// Logarithmic strain in the plane, plane strain across it (Guo et al. 2018, as far as the paper describes it).
// For comparison only (paper, Fig. 9).
#include "shell/mechanics/law.h"

namespace sunder::shell {

/// asinh(y) / y for y >= 0, with y^2 given: 1 where the stretches are equal.
template <class T>
inline T asinh_over(T y2) {
  const T y = square_root(y2);
  const T exact = logarithm<T>(y + square_root(y2 + 1.0)) / select(y > 0.0, y, splat<T>(1.0));
  // the logarithm's argument loses what is near 1; the rest of the series is below 1e-16 there
  const T series = 1.0 - y2 * (1.0 / 6.0 - y2 * (3.0 / 40.0 - y2 * (15.0 / 336.0)));
  return select(y2 > 1e-4, exact, series);
}

/// psi = mu |ln U|^2 + lambda/2 (ln J)^2, with ln(s1 / s2) = asinh(y), y^2 = (I / 2 J)^2 - 1.
struct Ghf18 {
  static constexpr const char* kName = "ghf18";
  static constexpr bool kKeepsThickness = true;
  Lame lame;
  explicit Ghf18(const ElasticConstants& c) : lame(lame_constants(c)) {}

  template <class T>
  PlaneEnergy<T> in_plane(const T& trace, const T& area, const T& log_area) const {
    const T over = trace / (2.0 * area);
    const T x = select(over > 1.0, over - 1.0, splat<T>(0.0));
    const T y2 = x * (x + 2.0), q = asinh_over<T>(y2);
    return {(0.5 * lame.mu) * (log_area * log_area + q * q * y2) + (0.5 * lame.lambda) * log_area * log_area,
            (0.5 * lame.mu) * q / area, ((lame.mu + lame.lambda) * log_area - lame.mu * q * (1.0 + x)) / area};
  }
  template <class T>
  PlaneStress<T> stress(const Sym2<T>& c, const Sym2<T>& a) const {
    return stress_in_plane<T>(*this, c, a);
  }
  template <class T>
  T energy(const PlaneStress<T>& p, const Sym2<T>& c, const Sym2<T>& a) const {
    return energy_in_plane<T>(*this, p, c, a);
  }
};

}  // namespace sunder::shell
