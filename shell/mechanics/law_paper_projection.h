#pragma once
// The paper's projection (section 6, eq. 10-13): the thickness is kept, stress across it is dropped.
#include "shell/mechanics/law_neo_hookean.h"

namespace sunder::shell {

/// Energy of the neo-Hookean material at a thickness stretch of 1, S = mu Abar^-1 - (mu - lambda ln J0) C^-1. The
/// modulus in the plane is lambda + 2 mu: too stiff.
struct PaperProjection {
  static constexpr const char* kName = "paper_projection";
  static constexpr bool kKeepsThickness = true;
  Lame lame;
  explicit PaperProjection(const ElasticConstants& c) : lame(lame_constants(c)) {}

  template <class T>
  PlaneStress<T> stress(const Sym2<T>& c, const Sym2<T>& a) const {
    const T dc = determinant(c), da = determinant(a), ia = 1.0 / da, ic = 1.0 / dc;
    PlaneStress<T> r = with_thickness_kept<T>(dc, da, ia);
    const T log_area = log_area_ratio<T>(r.share, r.area2);
    const T push = (lame.mu - lame.lambda * log_area) * ic;
    r.s = {lame.mu * (a.c22 * ia) - push * c.c22, lame.mu * (a.c11 * ia) - push * c.c11,
           push * c.c12 - lame.mu * (a.c12 * ia)};
    return r;
  }
  template <class T>
  T energy(const PlaneStress<T>& p, const Sym2<T>& c, const Sym2<T>& a) const {
    return neo_hookean_energy<T>(p, c, a, lame);
  }
};

}  // namespace sunder::shell
