#pragma once
// Compressible neo-Hookean material in true plane stress, in curvilinear components.
#include <algorithm>
#include <array>
#include <limits>

#include "shell/mechanics/law.h"

namespace sunder::shell {

/// 1 + c_1 z + c_2 z^2 + ...
template <class T>
inline T series(const std::array<double, kSeriesTerms>& c, const T& z) {
  T sum = splat<T>(c[kSeriesTerms - 1]);
  for (int k = kSeriesTerms - 2; k >= 0; --k) sum = sum * z + c[k];
  return 1.0 + z * sum;
}

/// w - ln(1 + w) for |w / (2 + w)| up to some kSmallShare, to round-off of itself: with z = w / (2 + w) it is
/// w z - 2 (z^3/3 + z^5/5 + ...).
template <class T>
inline T less_its_log(const T& w) {
  const T z = w / (2.0 + w), z2 = z * z;
  return w * z - 2.0 * z * z2 * (1.0 / 3.0 + z2 * (1.0 / 5.0 + z2 * (1.0 / 7.0 + z2 * (1.0 / 9.0))));
}

/// psi = mu/2 (tr C - 3) - mu ln J + lambda/2 ln^2 J [J/m^3] at the thickness stretch in `p`. It is of second order in
/// the strain. Near the reference state terms of first order would cancel and leave round-off of E instead of
/// round-off of the energy (sheets a hundred thousand times as long as thick bend by strains of 1e-9). There, with
/// G = C - Abar,
///   psi = mu/2 (h(w) - det G / det Abar) + mu/2 h(s - 1) + lambda/2 ln^2 J,  w = J0^2 - 1,  h(x) = x - ln(1 + x).
template <class T>
[[gnu::always_inline]] inline T neo_hookean_energy(const PlaneStress<T>& p, const Sym2<T>& c, const Sym2<T>& a,
                                                   const Lame& e) {
  const T inverse_det = 1.0 / determinant(a), log_area = log_area_ratio<T>(p.share, p.area2);
  const T log_j = log_area + 0.5 * logarithm<T>(p.stretch2);
  const T by_volume = 0.5 * e.lambda * log_j * log_j;
  if (all_below(p.share, kSmallShare)) {
    const Sym2<T> g{c.c11 - a.c11, c.c22 - a.c22, c.c12 - a.c12};
    const T second = determinant(g) * inverse_det, w = trace_of<T>(g, a, inverse_det) + second;
    return 0.5 * e.mu * (less_its_log<T>(w) - second + less_its_log<T>(p.stretch2 - 1.0)) + by_volume;
  }
  const T trace = trace_of<T>(c, a, inverse_det);
  return 0.5 * e.mu * (trace + p.stretch2 - 3.0) - e.mu * log_j + by_volume;
}

/// The thickness stretch follows from sigma_33 = 0. With s = stretch^2 and J0 the area ratio,
///   g(s) = mu (s - 1) + lambda/2 ln s + lambda ln J0 = 0,  S = mu (Abar^-1 - s C^-1).
struct NeoHookean {
  static constexpr const char* kName = "plane_stress";
  static constexpr bool kKeepsThickness = false;
  Lame lame;
  double least_log_area = -std::numeric_limits<double>::infinity();  // see find_least_log_area
  // Coefficients of z, z^2, ... in the thickness stretch squared and in the volume ratio.
  std::array<double, kSeriesTerms> stretch{}, volume{};

  NeoHookean() = default;
  explicit NeoHookean(const ElasticConstants& c) : lame(lame_constants(c)) {
    find_least_log_area();
    find_series();
  }

  template <class T>
  [[gnu::always_inline]] inline PlaneStress<T> stress(const Sym2<T>& c, const Sym2<T>& a) const {
    const T dc = determinant(c), da = determinant(a), sum = dc + da, both = dc * da;
    const T inverse = 1.0 / (both * sum);  // divisions are what a layer costs most: one for three
    const T ia = inverse * dc * sum;
    PlaneStress<T> r;
    r.area2 = dc * ia;
    r.share = (dc - da) * inverse * both;
    if (all_below(r.share, kSmallShare))
      r.stretch2 = series<T>(stretch, r.share);
    else
      r.stretch2 = find_far_stretch<T>(r.area2);
    const T ic = r.stretch2 * (inverse * da * sum);
    r.s = {lame.mu * (a.c22 * ia - ic * c.c22), lame.mu * (a.c11 * ia - ic * c.c11),
           lame.mu * (ic * c.c12 - a.c12 * ia)};
    return r;
  }

  template <class T>
  [[gnu::always_inline]] inline T energy(const PlaneStress<T>& p, const Sym2<T>& c, const Sym2<T>& a) const {
    return neo_hookean_energy<T>(p, c, a, lame);
  }

 private:
  /// With lambda < 0 (Poisson's ratio below 0) g(s) has no root below some ln J0: the sheet would thin by itself
  /// without end. Finds the least ln J0 that has a root; minus infinity where all have.
  void find_least_log_area() {
    if (lame.lambda >= 0.0) return;
    const double half = 0.5 * lame.lambda;  // g is least at e^u = -half / mu
    least_log_area = (lame.mu + half - half * std::log(-half / lame.mu)) / lame.lambda;
  }

  /// With ln J0 = atanh z the derivative of g(s) = 0 by z is s' (mu s + lambda/2) = -lambda s / (1 - z^2). It gives the
  /// coefficients of s one after the other. Those of J = J0 sqrt(s) follow from J' = J (1 / (1 - z^2) + s' / 2s).
  void find_series() {
    std::array<double, kSeriesTerms + 1> s{1.0}, log_s{}, v{1.0};  // log_s: of s'/s
    for (int k = 0; k < kSeriesTerms; ++k) {
      double sum = 0.0;
      for (int j = 0; j <= k; j += 2) sum -= lame.lambda * s[k - j];
      for (int i = 1; i <= k; ++i) sum -= lame.mu * s[i] * (k + 1 - i) * s[k + 1 - i];
      s[k + 1] = sum / ((lame.mu + 0.5 * lame.lambda) * (k + 1));
      log_s[k] = (k + 1) * s[k + 1];
      for (int i = 1; i <= k; ++i) log_s[k] -= s[i] * log_s[k - i];
      double grown = 0.0;
      for (int i = 0; i <= k; ++i) grown += v[k - i] * ((i % 2 == 0 ? 1.0 : 0.0) + 0.5 * log_s[i]);
      v[k + 1] = grown / (k + 1);
    }
    std::copy(s.begin() + 1, s.end(), stretch.begin());
    std::copy(v.begin() + 1, v.end(), volume.begin());
  }

  static constexpr int kMostNewtonSteps = 40;  // few are needed, but near the least area of lambda < 0
  static constexpr double kConverged = 1e-8;   // last step, of the stretch

  /// s from the squared area ratio `area2`, however far from 1: Newton from the root of the linearised equation. A step
  /// takes s to a quarter of itself at the least, since the root is positive and the logarithm ends at zero. Out of
  /// line, so that the common case fits the registers.
  template <class T>
  [[gnu::noinline]] T find_far_stretch(T area2) const {
    T log_area = 0.5 * logarithm<T>(area2);
    // where there is no root, as at the least area: solver/compression.h stops the run
    if (lame.lambda < 0.0) log_area = select(log_area > least_log_area, log_area, splat<T>(least_log_area));
    const T u = -2.0 * lame.lambda / (lame.lambda + 2.0 * lame.mu) * log_area;  // ln s to first order
    T s = 1.0 + u * (1.0 + u * (0.5 + u * (1.0 / 6.0 + u * (1.0 / 24.0))));     // exp(u) to O(u^5)
    s = select(s > 0.05, s, splat<T>(0.05));
    for (int i = 0; i < kMostNewtonSteps; ++i) {
      const T g = lame.mu * (s - 1.0) + (0.5 * lame.lambda) * logarithm<T>(s) + lame.lambda * log_area;
      const T step = g / (lame.mu + 0.5 * lame.lambda / s);
      const T next = s - step;
      s = select(next > 0.25 * s, next, 0.25 * s);
      if (all_below(step / s, kConverged)) break;  // the error squares every time: the next would be round-off
    }
    return s;
  }
};

}  // namespace sunder::shell
