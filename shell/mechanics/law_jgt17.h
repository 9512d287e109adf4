#pragma once
// Fixed corotated energy of the deformation in the plane (Jiang, Gast, Teran 2017, as far as the paper describes it).
// For comparison only (paper, Fig. 9).
#include "shell/mechanics/law.h"

namespace sunder::shell {

/// psi = mu |F - R|^2 + lambda/2 (J - 1)^2, F 2x2, with the sum of the stretches s1 + s2 = sqrt(I + 2 J).
struct Jgt17 {
  static constexpr const char* kName = "jgt17";
  static constexpr bool kKeepsThickness = true;
  Lame lame;
  explicit Jgt17(const ElasticConstants& c) : lame(lame_constants(c)) {}

  // Out of line: the trace is rounded before it is added to 2 J.
  template <class T>
  [[gnu::noinline]] PlaneEnergy<T> in_plane(const T& trace, const T& area, const T&) const {
    const T sum = square_root(trace + 2.0 * area);
    return {lame.mu * (trace - 2.0 * sum + 2.0) + (0.5 * lame.lambda) * (area - 1.0) * (area - 1.0),
            lame.mu * (1.0 - 1.0 / sum), lame.lambda * (area - 1.0) - (2.0 * lame.mu) / sum};
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
