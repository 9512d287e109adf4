#pragma once
// What every elastic law of a layer is made from, and what it returns.
#include <concepts>

#include "shell/mechanics/pack.h"

namespace sunder::shell {

/// Symmetric 2x2 tensor: components 11, 22, 12.
template <class T>
struct Sym2 {
  T c11, c22, c12;
};

template <class T>
inline T determinant(const Sym2<T>& a) {
  return a.c11 * a.c22 - a.c12 * a.c12;
}

/// Constants of a material that an elastic law may read. A law with further parameters adds them here.
struct ElasticConstants {
  double youngs_modulus = 0.0;  // [Pa]
  double poisson_ratio = 0.0;   // [-]
};

/// Lame constants [Pa].
struct Lame {
  double mu = 0.0, lambda = 0.0;
};
inline Lame lame_constants(const ElasticConstants& c) {
  return {c.youngs_modulus / (2.0 * (1.0 + c.poisson_ratio)),
          c.youngs_modulus * c.poisson_ratio / ((1.0 + c.poisson_ratio) * (1.0 - 2.0 * c.poisson_ratio))};
}

/// State of a layer under a law.
template <class T>
struct PlaneStress {
  Sym2<T> s;   // second Piola-Kirchhoff stress, contravariant [Pa / metric]
  T stretch2;  // thickness stretch squared
  T area2;     // J0^2, J0 the area ratio
  T share;     // (J0^2 - 1) / (J0^2 + 1)
};

/// What an elastic law offers. `stress` and `energy` take the current metric C and the reference metric Abar of the
/// layer, both covariant and positive definite: S^ab = 2 d psi / d C_ab, and psi [J/m^3] per reference volume at the
/// state that `stress` returned. Both are templates of the number: a pack of lanes, or a double.
template <class Law>
concept IsElasticLaw = std::constructible_from<Law, const ElasticConstants&> &&
    requires(const Law& law, const Sym2<double>& c, const PlaneStress<double>& p) {
  { Law::kName } -> std::convertible_to<const char*>;     // as in a scene, lower case
  { Law::kKeepsThickness } -> std::convertible_to<bool>;  // false: no stress acts across the thickness
  { law.template stress<double>(c, c) } -> std::same_as<PlaneStress<double>>;
  { law.template energy<double>(p, c, c) } -> std::same_as<double>;
};

/// The area ratio is near 1 where |z| = |J0^2 - 1| / (J0^2 + 1) is below it. There power series in z of kSeriesTerms
/// are exact to round-off: they leave out at most (2 z)^11 of a strain of z. Farther off the laws take logarithms.
/// Shells of glass and steel stay in the range of the series until they break.
constexpr int kSeriesTerms = 10;
constexpr double kSmallShare = 0.02;

inline bool all_below(double a, double limit) { return a < limit && a > -limit; }
template <class P>
requires kIsPack<P>
inline bool all_below(P a, double limit) { return !any((a >= limit) | (a <= -limit) | (a != a)); }

/// ln J0.
template <class T>
inline T log_area_ratio(const T& share, const T& area2) {
  return all_below(share, kSmallShare) ? 0.5 * twice_atanh<9, T>(share) : 0.5 * logarithm<T>(area2);
}

/// tr(Abar^-1 C).
template <class T>
inline T trace_of(const Sym2<T>& c, const Sym2<T>& a, const T& inverse_det_a) {
  return (c.c11 * a.c22 + c.c22 * a.c11 - 2.0 * c.c12 * a.c12) * inverse_det_a;
}

/// Area ratio and unit thickness of the laws that keep the thickness; `s` is still to be found.
template <class T>
inline PlaneStress<T> with_thickness_kept(const T& det_c, const T& det_a, const T& inverse_det_a) {
  PlaneStress<T> r;
  r.area2 = det_c * inverse_det_a;
  r.share = (det_c - det_a) / (det_c + det_a);
  r.stretch2 = splat<T>(1.0);
  return r;
}

/// psi(I, J) of a law that knows the plane alone, I = tr(Abar^-1 C) and J the area ratio: psi, its derivatives by I
/// and J.
template <class T>
struct PlaneEnergy {
  T energy, by_trace, by_area;
};

/// S = 2 psi_I Abar^-1 + psi_J J C^-1 of such a law.
template <class T, class Law>
inline PlaneStress<T> stress_in_plane(const Law& law, const Sym2<T>& c, const Sym2<T>& a) {
  const T dc = determinant(c), da = determinant(a), ia = 1.0 / da, ic = 1.0 / dc;
  PlaneStress<T> r = with_thickness_kept<T>(dc, da, ia);
  const T log_area = log_area_ratio<T>(r.share, r.area2);
  const T area = square_root(r.area2);
  const PlaneEnergy<T> psi = law.template in_plane<T>(trace_of<T>(c, a, ia), area, log_area);
  const T first = 2.0 * psi.by_trace * ia, second = psi.by_area * area * ic;
  r.s = {first * a.c22 + second * c.c22, first * a.c11 + second * c.c11, -first * a.c12 - second * c.c12};
  return r;
}
template <class T, class Law>
inline T energy_in_plane(const Law& law, const PlaneStress<T>& p, const Sym2<T>& c, const Sym2<T>& a) {
  const T inverse_det = 1.0 / determinant(a), log_area = log_area_ratio<T>(p.share, p.area2);
  return law.template in_plane<T>(trace_of<T>(c, a, inverse_det), square_root(p.area2), log_area).energy;
}

}  // namespace sunder::shell
