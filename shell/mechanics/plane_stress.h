#pragma once
// Compressible neo-Hookean material in true plane stress, in curvilinear components.
#include <algorithm>
#include <array>
#include <limits>

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

/// How the stress of a layer follows from its strain in the plane.
enum class StressModel {
  kPlaneStress,      // the thickness stretches so that nothing acts across it
  kPaperProjection,  // the thickness keeps, stress across it is dropped (paper, eq. 11-13): lambda + 2 mu in the plane
  // For comparison only (paper, Fig. 9); both keep the thickness as well. The models of Jiang, Gast and Teran 2017 and
  // of Guo et al. 2018, as far as the paper describes them.
  kJgt17,  // fixed corotated energy of the deformation gradient in the plane
  kGhf18,  // logarithmic strain in the plane, plane strain across it
};

/// Powers of z = (J0^2 - 1) / (J0^2 + 1), |z| < kSmallShare, that give thickness stretch and volume to round-off: at
/// most (2 z)^11 is left out, of a strain of z. Beyond, logarithms; shells of glass and steel never leave that range
/// until they break.
constexpr int kSeriesTerms = 10;
constexpr double kSmallShare = 0.02;

/// Lame constants [Pa].
struct Elasticity {
  double mu = 0.0, lambda = 0.0;
  StressModel model = StressModel::kPlaneStress;
  double least_log_area = -std::numeric_limits<double>::infinity();  // see find_least_log_area
  // Of the thickness stretch squared and of the volume ratio, powers of (J0^2 - 1) / (J0^2 + 1) from the first.
  std::array<double, kSeriesTerms> stretch{}, volume{};
};
/// With lambda < 0 (Poisson's ratio below 0) g(s) has no root below some ln J0: the sheet would go on thinning by
/// itself. Least ln J0 that has one; minus infinity where all have.
inline double find_least_log_area(const Elasticity& e) {
  if (e.lambda >= 0.0 || e.model != StressModel::kPlaneStress) return -std::numeric_limits<double>::infinity();
  const double half = 0.5 * e.lambda;  // g is least at e^u = -half / mu
  return (e.mu + half - half * std::log(-half / e.mu)) / e.lambda;
}

/// With ln J0 = atanh z the derivative of g(s) = mu (s - 1) + lambda/2 ln s + lambda ln J0 = 0 by z is
/// s' (mu s + lambda/2) = -lambda s / (1 - z^2), which gives the coefficients of s one after the other; those of
/// J = J0 sqrt(s) follow from J' = J (1 / (1 - z^2) + s' / 2s).
inline void find_series(Elasticity& e) {
  std::array<double, kSeriesTerms + 1> s{1.0}, log_s{}, v{1.0};  // log_s: of s'/s
  for (int k = 0; k < kSeriesTerms; ++k) {
    double sum = 0.0;
    for (int j = 0; j <= k; j += 2) sum -= e.lambda * s[k - j];
    for (int i = 1; i <= k; ++i) sum -= e.mu * s[i] * (k + 1 - i) * s[k + 1 - i];
    s[k + 1] = sum / ((e.mu + 0.5 * e.lambda) * (k + 1));
    log_s[k] = (k + 1) * s[k + 1];
    for (int i = 1; i <= k; ++i) log_s[k] -= s[i] * log_s[k - i];
    double grown = 0.0;
    for (int i = 0; i <= k; ++i) grown += v[k - i] * ((i % 2 == 0 ? 1.0 : 0.0) + 0.5 * log_s[i]);
    v[k + 1] = grown / (k + 1);
  }
  std::copy(s.begin() + 1, s.end(), e.stretch.begin());
  std::copy(v.begin() + 1, v.end(), e.volume.begin());
}

inline Elasticity elasticity(double youngs_modulus, double poisson_ratio) {
  Elasticity e;
  e.mu = youngs_modulus / (2.0 * (1.0 + poisson_ratio));
  e.lambda = youngs_modulus * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio));
  find_series(e);
  return e;
}

/// 1 + c_1 z + c_2 z^2 + ...
template <class T>
inline T series(const std::array<double, kSeriesTerms>& c, const T& z) {
  T sum = splat<T>(c[kSeriesTerms - 1]);
  for (int k = kSeriesTerms - 2; k >= 0; --k) sum = sum * z + c[k];
  return 1.0 + z * sum;
}

inline bool keeps_thickness(StressModel model) { return model != StressModel::kPlaneStress; }

/// Newton steps for the thickness stretch of large strain: few, but near the least area of lambda < 0.
constexpr int kMostNewtonSteps = 40;
constexpr double kConverged = 1e-8;  // last step, of the stretch

template <class T>
struct PlaneStress {
  Sym2<T> s;   // second Piola-Kirchhoff stress, contravariant [Pa / metric]
  T stretch2;  // thickness stretch squared
  T area2;     // J0^2, J0 the area ratio
  T share;     // (J0^2 - 1) / (J0^2 + 1)
};

inline bool all_below(double a, double limit) { return a < limit && a > -limit; }
template <class P>
requires kIsPack<P>
inline bool all_below(P a, double limit) { return !any((a >= limit) | (a <= -limit) | (a != a)); }

/// ln J0.
template <class T>
inline T log_area_ratio(const T& share, const T& area2) {
  return all_below(share, kSmallShare) ? 0.5 * twice_atanh<9, T>(share) : 0.5 * logarithm<T>(area2);
}

/// asinh(y) / y for y >= 0, with y^2 given: 1 where the stretches are equal.
template <class T>
inline T asinh_over(T y2) {
  const T y = square_root(y2);
  const T exact = logarithm<T>(y + square_root(y2 + 1.0)) / select(y > 0.0, y, splat<T>(1.0));
  // the logarithm's argument loses what is near 1; the rest of the series below 1e-16 there
  const T series = 1.0 - y2 * (1.0 / 6.0 - y2 * (3.0 / 40.0 - y2 * (15.0 / 336.0)));
  return select(y2 > 1e-4, exact, series);
}

/// A law psi(I, J) of the plane alone, I = tr(Abar^-1 C) and J the area ratio: psi, its derivatives by I and J.
template <class T>
struct PlaneLaw {
  T energy, by_trace, by_area;
};
/// kJgt17: psi = mu |F - R|^2 + lambda/2 (J - 1)^2, F 2x2, with the stretches' sum s1 + s2 = sqrt(I + 2 J).
/// kGhf18: psi = mu |ln U|^2 + lambda/2 (ln J)^2, with ln(s1 / s2) = asinh(y), y^2 = (I / 2 J)^2 - 1.
template <class T>
inline PlaneLaw<T> plane_law(const T& trace, const T& area, const T& log_area, const Elasticity& e) {
  if (e.model == StressModel::kJgt17) {
    const T sum = square_root(trace + 2.0 * area);
    return {e.mu * (trace - 2.0 * sum + 2.0) + (0.5 * e.lambda) * (area - 1.0) * (area - 1.0), e.mu * (1.0 - 1.0 / sum),
            e.lambda * (area - 1.0) - (2.0 * e.mu) / sum};
  }
  const T over = trace / (2.0 * area);
  const T x = select(over > 1.0, over - 1.0, splat<T>(0.0));
  const T y2 = x * (x + 2.0), q = asinh_over<T>(y2);
  return {(0.5 * e.mu) * (log_area * log_area + q * q * y2) + (0.5 * e.lambda) * log_area * log_area,
          (0.5 * e.mu) * q / area, ((e.mu + e.lambda) * log_area - e.mu * q * (1.0 + x)) / area};
}
template <class T>
inline T trace_of(const Sym2<T>& c, const Sym2<T>& a, const T& inverse_det_a) {
  return (c.c11 * a.c22 + c.c22 * a.c11 - 2.0 * c.c12 * a.c12) * inverse_det_a;
}

/// The models that keep the thickness. Out of line, as what is large: the common case then fits the registers.
template <class T>
[[gnu::noinline]] PlaneStress<T> plane_strain_stress(const Sym2<T>& c, const Sym2<T>& a, const Elasticity& e) {
  const T dc = determinant(c), da = determinant(a), ia = 1.0 / da, ic = 1.0 / dc;
  PlaneStress<T> r;
  r.area2 = dc * ia;
  r.share = (dc - da) / (dc + da);
  r.stretch2 = splat<T>(1.0);
  const T log_area = log_area_ratio<T>(r.share, r.area2);
  if (e.model == StressModel::kPaperProjection) {
    const T push = (e.mu - e.lambda * log_area) * ic;  // S = mu Abar^-1 - (mu - lambda ln J) C^-1
    r.s = {e.mu * (a.c22 * ia) - push * c.c22, e.mu * (a.c11 * ia) - push * c.c11, push * c.c12 - e.mu * (a.c12 * ia)};
    return r;
  }
  const T area = square_root(r.area2);  // S = 2 psi_I Abar^-1 + psi_J J C^-1
  const PlaneLaw<T> law = plane_law<T>(trace_of<T>(c, a, ia), area, log_area, e);
  const T first = 2.0 * law.by_trace * ia, second = law.by_area * area * ic;
  r.s = {first * a.c22 + second * c.c22, first * a.c11 + second * c.c11, -first * a.c12 - second * c.c12};
  return r;
}

/// Thickness stretch from the squared area ratio `area2`, however far from 1: Newton in s from the root of the
/// linearised equation; a step may take s to a quarter of itself at the least, since the root is positive and the
/// logarithm ends at zero.
template <class T>
[[gnu::noinline]] T find_far_stretch(T area2, const Elasticity& e) {
  T log_area = 0.5 * logarithm<T>(area2);
  // where there is no root, as if compressed no further: solver/compression.h stops the run
  if (e.lambda < 0.0) log_area = select(log_area > e.least_log_area, log_area, splat<T>(e.least_log_area));
  const T u = -2.0 * e.lambda / (e.lambda + 2.0 * e.mu) * log_area;        // ln s to first order
  T s = 1.0 + u * (1.0 + u * (0.5 + u * (1.0 / 6.0 + u * (1.0 / 24.0))));  // exp(u) to O(u^5)
  s = select(s > 0.05, s, splat<T>(0.05));
  for (int i = 0; i < kMostNewtonSteps; ++i) {
    const T g = e.mu * (s - 1.0) + (0.5 * e.lambda) * logarithm<T>(s) + e.lambda * log_area;
    const T step = g / (e.mu + 0.5 * e.lambda / s);
    const T next = s - step;
    s = select(next > 0.25 * s, next, 0.25 * s);
    if (all_below(step / s, kConverged)) break;  // the error squares every time: the next would be round-off
  }
  return s;
}

/// psi = mu/2 (tr C - 3) - mu ln J + lambda/2 ln^2 J with the thickness stretch from sigma_33 = 0:
///   g(s) = mu (s - 1) + lambda/2 ln s + lambda ln J0 = 0,  s = stretch^2;  S = mu (Abar^-1 - s C^-1).
/// `c` is the current, `a` the reference metric at this layer (covariant, both positive definite).
/// Near the reference state s is a series in z = (J0^2 - 1) / (J0^2 + 1).
template <class T>
[[gnu::always_inline]] inline PlaneStress<T> plane_stress(const Sym2<T>& c, const Sym2<T>& a, const Elasticity& e) {
  if (keeps_thickness(e.model)) {
    const Sym2<T> c_there = c, a_there = a;  // only these copies have an address, the rest stays in registers
    return plane_strain_stress<T>(c_there, a_there, e);
  }
  const T dc = determinant(c), da = determinant(a), sum = dc + da, both = dc * da;
  const T inverse = 1.0 / (both * sum);  // divisions are what a layer costs most: one for three
  const T ia = inverse * dc * sum;
  PlaneStress<T> r;
  r.area2 = dc * ia;
  r.share = (dc - da) * inverse * both;
  if (all_below(r.share, kSmallShare))
    r.stretch2 = series<T>(e.stretch, r.share);
  else
    r.stretch2 = find_far_stretch<T>(r.area2, e);
  const T ic = r.stretch2 * (inverse * da * sum);
  r.s = {e.mu * (a.c22 * ia - ic * c.c22), e.mu * (a.c11 * ia - ic * c.c11), e.mu * (ic * c.c12 - a.c12 * ia)};
  return r;
}

/// Volume ratio J. A root costs more than the series.
template <class T>
inline T volume_ratio(const PlaneStress<T>& p, const Elasticity& e) {
  if (!keeps_thickness(e.model) && all_below(p.share, kSmallShare)) return series<T>(e.volume, p.share);
  return square_root(p.area2 * p.stretch2);
}

/// w - ln(1 + w) for |w / (2 + w)| up to some kSmallShare, to round-off of itself: with z = w / (2 + w) it is
/// w z - 2 (z^3/3 + z^5/5 + ...).
template <class T>
inline T less_its_log(const T& w) {
  const T z = w / (2.0 + w), z2 = z * z;
  return w * z - 2.0 * z * z2 * (1.0 / 3.0 + z2 * (1.0 / 5.0 + z2 * (1.0 / 7.0 + z2 * (1.0 / 9.0))));
}

/// Energy per reference volume [J/m^3] of the same state. It is of second order in the strain; near the reference state
/// the terms of first order are not summed up to cancel, which would leave round-off of E instead of round-off of the
/// energy (sheets a hundred thousand times as long as thick bend by strains of 1e-9): with G = C - Abar,
///   psi = mu/2 (h(w) - det G / det Abar) + mu/2 h(s - 1) + lambda/2 ln^2 J,  w = J0^2 - 1,  h(x) = x - ln(1 + x).
template <class T>
inline T plane_stress_energy(const PlaneStress<T>& p, const Sym2<T>& c, const Sym2<T>& a, const Elasticity& e) {
  const T inverse_det = 1.0 / determinant(a), log_area = log_area_ratio<T>(p.share, p.area2);
  if (e.model == StressModel::kJgt17 || e.model == StressModel::kGhf18)
    return plane_law<T>(trace_of<T>(c, a, inverse_det), square_root(p.area2), log_area, e).energy;
  const T log_j = log_area + 0.5 * logarithm<T>(p.stretch2);
  const T by_volume = 0.5 * e.lambda * log_j * log_j;
  if (all_below(p.share, kSmallShare)) {
    const Sym2<T> g{c.c11 - a.c11, c.c22 - a.c22, c.c12 - a.c12};
    const T second = determinant(g) * inverse_det, w = trace_of<T>(g, a, inverse_det) + second;
    return 0.5 * e.mu * (less_its_log<T>(w) - second + less_its_log<T>(p.stretch2 - 1.0)) + by_volume;
  }
  const T trace = trace_of<T>(c, a, inverse_det);  // tr(Abar^-1 C)
  return 0.5 * e.mu * (trace + p.stretch2 - 3.0) - e.mu * log_j + by_volume;
}

}  // namespace sunder::shell
