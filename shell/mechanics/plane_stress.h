#pragma once
// Compressible neo-Hookean material in true plane stress, in curvilinear components.
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

/// Lame constants [Pa].
struct Elasticity {
  double mu = 0.0, lambda = 0.0;
  StressModel model = StressModel::kPlaneStress;
  double least_log_area = -std::numeric_limits<double>::infinity();  // see find_least_log_area
};
/// With lambda < 0 (Poisson's ratio below 0) g(s) has no root below some ln J0: the sheet would go on thinning by
/// itself. Least ln J0 that has one; minus infinity where all have.
inline double find_least_log_area(const Elasticity& e) {
  if (e.lambda >= 0.0 || e.model != StressModel::kPlaneStress) return -std::numeric_limits<double>::infinity();
  const double half = 0.5 * e.lambda;  // g is least at e^u = -half / mu
  return (e.mu + half - half * std::log(-half / e.mu)) / e.lambda;
}

inline Elasticity elasticity(double youngs_modulus, double poisson_ratio) {
  return {youngs_modulus / (2.0 * (1.0 + poisson_ratio)),
          youngs_modulus * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio))};
}

inline bool keeps_thickness(StressModel model) { return model != StressModel::kPlaneStress; }

/// Newton steps for the thickness stretch beyond the first (which is exact to second order in strain).
/// Convex, so it converges from one side; the error squares every time, but near the least area of lambda < 0.
constexpr int kThicknessNewtonSteps = 3, kAuxeticNewtonSteps = 12;

template <class T>
struct PlaneStress {
  Sym2<T> s;       // second Piola-Kirchhoff stress, contravariant [Pa / metric]
  T stretch2;      // thickness stretch squared
  T log_area;      // ln J0, J0 the area ratio
  T area2;         // J0^2
  T log_stretch2;  // its logarithm; beyond kSmallAreaChange where it is not small
};

/// Area ratios nearer to 1 than this take polynomials, which are exact to round-off there, instead of
/// logarithms; shells of glass and steel never leave that range until they break.
constexpr double kSmallAreaChange = 0.04;

inline bool all_below(double a, double limit) { return a < limit && a > -limit; }
template <class P>
requires kIsPack<P>
inline bool all_below(P a, double limit) { return !any((a >= limit) | (a <= -limit) | (a != a)); }

/// e^u - 1 for |u| < 0.04: the rest of the series below 1e-16 of it, and of the stress less still.
template <class T>
inline T small_expm1(T u) {
  T s = splat<T>(1.0 / 40320.0);
  s = s * u + 1.0 / 5040.0;
  s = s * u + 1.0 / 720.0;
  s = s * u + 1.0 / 120.0;
  s = s * u + 1.0 / 24.0;
  s = s * u + 1.0 / 6.0;
  s = s * u + 0.5;
  return u + u * u * s;
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
  r.log_area = all_below((dc - da) * ia, kSmallAreaChange) ? 0.5 * twice_atanh<9, T>((dc - da) / (dc + da))
                                                           : 0.5 * logarithm<T>(r.area2);
  r.stretch2 = splat<T>(1.0);
  r.log_stretch2 = splat<T>(0.0);
  if (e.model == StressModel::kPaperProjection) {
    const T push = (e.mu - e.lambda * r.log_area) * ic;  // S = mu Abar^-1 - (mu - lambda ln J) C^-1
    r.s = {e.mu * (a.c22 * ia) - push * c.c22, e.mu * (a.c11 * ia) - push * c.c11, push * c.c12 - e.mu * (a.c12 * ia)};
    return r;
  }
  const T area = square_root(r.area2);  // S = 2 psi_I Abar^-1 + psi_J J C^-1
  const PlaneLaw<T> law = plane_law<T>(trace_of<T>(c, a, ia), area, r.log_area, e);
  const T first = 2.0 * law.by_trace * ia, second = law.by_area * area * ic;
  r.s = {first * a.c22 + second * c.c22, first * a.c11 + second * c.c11, -first * a.c12 - second * c.c12};
  return r;
}

/// Thickness stretch from the squared area ratio `area2`, however far from 1: Newton in s from the root of the
/// linearised equation; a step may take s to a quarter of itself at the least, since the root is positive and the
/// logarithm ends at zero.
template <class T>
struct FarStretch {
  T log_area, stretch2;
};
template <class T>
[[gnu::noinline]] FarStretch<T> find_far_stretch(T area2, const Elasticity& e) {
  FarStretch<T> r;
  r.log_area = 0.5 * logarithm<T>(area2);
  // where there is no root, as if compressed no further: solver/compression.h stops the run
  if (e.lambda < 0.0) r.log_area = select(r.log_area > e.least_log_area, r.log_area, splat<T>(e.least_log_area));
  const T u = -2.0 * e.lambda / (e.lambda + 2.0 * e.mu) * r.log_area;      // ln s to first order
  T s = 1.0 + u * (1.0 + u * (0.5 + u * (1.0 / 6.0 + u * (1.0 / 24.0))));  // exp(u) to O(u^5)
  s = select(s > 0.05, s, splat<T>(0.05));
  for (int i = 0; i < (e.lambda < 0.0 ? kAuxeticNewtonSteps : kThicknessNewtonSteps); ++i) {
    const T g = e.mu * (s - 1.0) + (0.5 * e.lambda) * logarithm<T>(s) + e.lambda * r.log_area;
    const T step = g / (e.mu + 0.5 * e.lambda / s);
    const T next = s - step;
    s = select(next > 0.25 * s, next, 0.25 * s);
  }
  r.stretch2 = s;
  return r;
}

/// psi = mu/2 (tr C - 3) - mu ln J + lambda/2 ln^2 J with the thickness stretch from sigma_33 = 0:
///   g(s) = mu (s - 1) + lambda/2 ln s + lambda ln J0 = 0,  s = stretch^2;  S = mu (Abar^-1 - s C^-1).
/// `c` is the current, `a` the reference metric at this layer (covariant, both positive definite).
/// Near the reference state Newton runs in u = ln s, once from a series (the error goes as u^4, u^8).
template <class T>
[[gnu::always_inline]] inline PlaneStress<T> plane_stress(const Sym2<T>& c, const Sym2<T>& a, const Elasticity& e) {
  if (keeps_thickness(e.model)) {
    const Sym2<T> c_there = c, a_there = a;  // only these copies have an address, the rest stays in registers
    return plane_strain_stress<T>(c_there, a_there, e);
  }
  const T dc = determinant(c), da = determinant(a), sum = dc + da, both = dc * da;
  const T inverse = 1.0 / (both * sum);  // divisions are what a layer costs most: one for three
  const T ia = inverse * dc * sum;
  const T change = (dc - da) * ia;  // of the squared area ratio
  PlaneStress<T> r;
  r.area2 = dc * ia;
  if (all_below(change, kSmallAreaChange)) {
    r.log_area = 0.5 * twice_atanh<9, T>((dc - da) * inverse * both);  // the rest of the series below 1e-17 of it
    // the root's series to third order, then Newton once
    const double kappa = 2.0 * e.lambda / (e.lambda + 2.0 * e.mu);
    const double beta = e.mu / (2.0 * e.mu + e.lambda), gamma = 2.0 * beta * beta - beta / 3.0;
    const T first = -kappa * r.log_area;
    T u = first * (1.0 - first * (beta - gamma * first));
    const T grown = small_expm1<T>(u);
    const double slope = e.mu + 0.5 * e.lambda;
    const T bend = (e.mu / slope) * grown;  // 1 / (1 + bend) to third order
    u = u - (1.0 - bend * (1.0 - bend * (1.0 - bend))) *
                ((e.mu / slope) * grown + (0.5 * e.lambda / slope) * u + (e.lambda / slope) * r.log_area);
    r.stretch2 = 1.0 + small_expm1<T>(u);
    r.log_stretch2 = u;
  } else {
    const FarStretch<T> far = find_far_stretch<T>(r.area2, e);
    r.log_area = far.log_area, r.stretch2 = far.stretch2, r.log_stretch2 = splat<T>(1.0);
  }
  const T ic = r.stretch2 * (inverse * da * sum);
  r.s = {e.mu * (a.c22 * ia - ic * c.c22), e.mu * (a.c11 * ia - ic * c.c11), e.mu * (ic * c.c12 - a.c12 * ia)};
  return r;
}

/// Volume ratio J; a root costs more than the series.
template <class T>
inline T volume_ratio(const PlaneStress<T>& p) {
  const T log_volume = p.log_area + 0.5 * p.log_stretch2;
  if (all_below(log_volume, kSmallAreaChange)) return 1.0 + small_expm1<T>(log_volume);
  return square_root(p.area2 * p.stretch2);
}

/// Energy per reference volume [J/m^3] of the same state.
template <class T>
inline T plane_stress_energy(const PlaneStress<T>& p, const Sym2<T>& c, const Sym2<T>& a, const Elasticity& e) {
  const T trace = trace_of<T>(c, a, 1.0 / determinant(a));  // tr(Abar^-1 C)
  if (e.model == StressModel::kJgt17 || e.model == StressModel::kGhf18)
    return plane_law<T>(trace, square_root(p.area2), p.log_area, e).energy;
  const T log_j = p.log_area + 0.5 * logarithm<T>(p.stretch2);
  return 0.5 * e.mu * (trace + p.stretch2 - 3.0) - e.mu * log_j + 0.5 * e.lambda * log_j * log_j;
}

}  // namespace sunder::shell
