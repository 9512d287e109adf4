#pragma once
// Compressible neo-Hookean material in true plane stress, in curvilinear components.
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
};

/// Lame constants [Pa].
struct Elasticity {
  double mu = 0.0, lambda = 0.0;
  StressModel model = StressModel::kPlaneStress;
};
inline Elasticity elasticity(double youngs_modulus, double poisson_ratio) {
  return {youngs_modulus / (2.0 * (1.0 + poisson_ratio)),
          youngs_modulus * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio))};
}

/// Newton steps for the thickness stretch beyond the first (which is exact to second order in strain).
/// Convex for lambda >= 0, so it converges from one side; the error squares every time.
constexpr int kThicknessNewtonSteps = 3;

template <class T>
struct PlaneStress {
  Sym2<T> s;   // second Piola-Kirchhoff stress, contravariant [Pa / metric]
  T stretch2;  // thickness stretch squared
  T log_area;  // ln J0, J0 the area ratio
  T area2;     // J0^2
};

/// Area ratios nearer to 1 than this take polynomials, which are exact to round-off there, instead of
/// logarithms; shells of glass and steel never leave that range until they break.
constexpr double kSmallAreaChange = 0.04;

inline bool all_below(double a, double limit) { return a < limit && a > -limit; }
template <class P>
requires kIsPack<P>
inline bool all_below(P a, double limit) { return !any((a >= limit) | (a <= -limit) | (a != a)); }

/// e^u - 1 for |u| < 0.04: the rest of the series below 1e-19.
template <class T>
inline T small_expm1(T u) {
  T s = splat<T>(1.0 / 362880.0);
  s = s * u + 1.0 / 40320.0;
  s = s * u + 1.0 / 5040.0;
  s = s * u + 1.0 / 720.0;
  s = s * u + 1.0 / 120.0;
  s = s * u + 1.0 / 24.0;
  s = s * u + 1.0 / 6.0;
  s = s * u + 0.5;
  return u + u * u * s;
}

/// psi = mu/2 (tr C - 3) - mu ln J + lambda/2 ln^2 J with the thickness stretch from sigma_33 = 0:
///   g(s) = mu (s - 1) + lambda/2 ln s + lambda ln J0 = 0,  s = stretch^2;  S = mu (Abar^-1 - s C^-1).
/// `c` is the current, `a` the reference metric at this layer (covariant, both positive definite).
/// Near the reference state Newton runs in u = ln s, once from a series (the error goes as u^4, u^8). Elsewhere
/// in s from the root of the linearised equation; a step may take s to a quarter of itself at the
/// least, since the root is positive and the logarithm ends at zero.
template <class T>
inline PlaneStress<T> plane_stress(const Sym2<T>& c, const Sym2<T>& a, const Elasticity& e) {
  const T dc = determinant(c), da = determinant(a), sum = dc + da, both = dc * da;
  const T inverse = 1.0 / (both * sum);  // divisions are what a layer costs most: one for three
  const T ia = inverse * dc * sum;
  const T change = (dc - da) * ia;  // of the squared area ratio
  const double kappa = 2.0 * e.lambda / (e.lambda + 2.0 * e.mu);
  PlaneStress<T> r;
  r.area2 = dc * ia;
  T s;
  if (e.model == StressModel::kPaperProjection) {
    r.log_area = all_below(change, kSmallAreaChange) ? 0.5 * twice_atanh<11, T>((dc - da) * inverse * both)
                                                     : 0.5 * logarithm<T>(r.area2);
    r.stretch2 = splat<T>(1.0);
    const T push = (e.mu - e.lambda * r.log_area) * (inverse * da * sum);  // S = mu Abar^-1 - (mu - lambda ln J) C^-1
    r.s = {e.mu * (a.c22 * ia) - push * c.c22, e.mu * (a.c11 * ia) - push * c.c11, push * c.c12 - e.mu * (a.c12 * ia)};
    return r;
  }
  if (all_below(change, kSmallAreaChange)) {
    r.log_area = 0.5 * twice_atanh<11, T>((dc - da) * inverse * both);  // the rest of the series below 1e-20
    // the root's series to third order, then Newton once
    const double beta = e.mu / (2.0 * e.mu + e.lambda), gamma = 2.0 * beta * beta - beta / 3.0;
    const T first = -kappa * r.log_area;
    T u = first * (1.0 - first * (beta - gamma * first));
    const T grown = small_expm1<T>(u);
    const double slope = e.mu + 0.5 * e.lambda;
    const T bend = (e.mu / slope) * grown;  // 1 / (1 + bend) to third order
    u = u - (1.0 - bend * (1.0 - bend * (1.0 - bend))) *
                ((e.mu / slope) * grown + (0.5 * e.lambda / slope) * u + (e.lambda / slope) * r.log_area);
    s = 1.0 + small_expm1<T>(u);
  } else {
    r.log_area = 0.5 * logarithm<T>(r.area2);
    const T u = -kappa * r.log_area;                                       // ln s to first order
    s = 1.0 + u * (1.0 + u * (0.5 + u * (1.0 / 6.0 + u * (1.0 / 24.0))));  // exp(u) to O(u^5)
    s = select(s > 0.05, s, splat<T>(0.05));
    for (int i = 0; i < kThicknessNewtonSteps; ++i) {
      const T g = e.mu * (s - 1.0) + (0.5 * e.lambda) * logarithm<T>(s) + e.lambda * r.log_area;
      const T step = g / (e.mu + 0.5 * e.lambda / s);
      const T next = s - step;
      s = select(next > 0.25 * s, next, 0.25 * s);
    }
  }
  r.stretch2 = s;
  const T ic = s * (inverse * da * sum);
  r.s = {e.mu * (a.c22 * ia - ic * c.c22), e.mu * (a.c11 * ia - ic * c.c11), e.mu * (ic * c.c12 - a.c12 * ia)};
  return r;
}

/// Energy per reference volume [J/m^3] of the same state.
template <class T>
inline T plane_stress_energy(const PlaneStress<T>& p, const Sym2<T>& c, const Sym2<T>& a, const Elasticity& e) {
  const T ia = 1.0 / determinant(a);
  const T trace = (c.c11 * a.c22 + c.c22 * a.c11 - 2.0 * c.c12 * a.c12) * ia;  // tr(Abar^-1 C)
  const T log_j = p.log_area + 0.5 * logarithm<T>(p.stretch2);
  return 0.5 * e.mu * (trace + p.stretch2 - 3.0) - e.mu * log_j + 0.5 * e.lambda * log_j * log_j;
}

}  // namespace sunder::shell
