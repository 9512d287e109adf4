#pragma once
// J2 plasticity of a layer in plane stress, with isotropic hardening, by a plastic reference metric.
#include "shell/mechanics/plane_stress.h"

namespace sunder::shell {

struct Yielding {
  double yield_stress = 0.0;       // [Pa]; 0: does not yield
  double hardening_modulus = 0.0;  // of the yield stress over the plastic strain [Pa]
  double youngs_modulus = 0.0, poisson_ratio = 0.0;
};

/// What a layer remembers of its plastic flow: how its reference metric has changed, and the equivalent strain.
template <class T>
struct PlasticState {
  Sym2<T> change;  // of the reference metric, covariant
  T strain;        // equivalent plastic strain
};

constexpr int kReturnSteps = 12;  // Newton on the multiplier; convex, from zero it converges from one side

/// Returns the trial state at metric `c` to the yield surface (Simo, Taylor 1986). Elastic strain is
/// (C - Abar)/2 with the plastic metric Abar = a + change; it is small, so trial stresses are those of Hooke's
/// law. The law and the yield condition share their eigentensors, mean and deviator, so the return scales both:
///   mean /= 1 + E dg / (3 (1 - nu)),  deviator /= 1 + 2 mu dg,
///   sigma P sigma(dg) = mean'^2 / 6 + dev' : dev' = 2/3 yield(strain + dg sqrt(2/3 sigma P sigma))^2,
/// and the reference metric takes what the elastic strain has lost, in any coordinates. Returns where it flowed.
template <class T>
inline auto return_to_yield(PlasticState<T>& p, const Sym2<T>& c, const Sym2<T>& a, const Yielding& y) {
  const double nu = y.poisson_ratio, two_mu = y.youngs_modulus / (1.0 + nu), bulk = y.youngs_modulus / (1.0 - nu);
  const Sym2<T> e{0.5 * (c.c11 - a.c11 - p.change.c11), 0.5 * (c.c22 - a.c22 - p.change.c22),
                  0.5 * (c.c12 - a.c12 - p.change.c12)};
  const T inverse = 1.0 / determinant(c);
  const T mean = 0.5 * (c.c22 * e.c11 + c.c11 * e.c22 - 2.0 * c.c12 * e.c12) * inverse;  // half the trace
  const Sym2<T> d{e.c11 - mean * c.c11, e.c22 - mean * c.c22, e.c12 - mean * c.c12};
  // the deviator's square: for a tensor without trace -2 det in mixed components
  const T square = -2.0 * determinant(d) * inverse;
  const T sum = 2.0 * bulk * mean;  // sigma_11 + sigma_22
  const T part_mean = sum * sum * (1.0 / 6.0), part_dev = (two_mu * two_mu) * square;
  const double k_mean = y.youngs_modulus / (3.0 * (1.0 - nu));
  const T limit0 = y.yield_stress + y.hardening_modulus * p.strain;
  const T over = part_mean + part_dev - (2.0 / 3.0) * limit0 * limit0;
  if (!any(over > 0.0)) return over > 0.0;  // mostly; the rest would change nothing, at ten times the cost
  T gamma{};
  for (int i = 0; i < kReturnSteps; ++i) {
    const T q_mean = 1.0 / (1.0 + k_mean * gamma), q_dev = 1.0 / (1.0 + two_mu * gamma);
    const T m2 = part_mean * q_mean * q_mean, d2 = part_dev * q_dev * q_dev, phi = m2 + d2;
    const T root = square_root(phi * (2.0 / 3.0));
    const T slope_phi = -2.0 * (k_mean * q_mean * m2 + two_mu * q_dev * d2);
    const T limit = limit0 + y.hardening_modulus * gamma * root;
    // d(gamma root)/dgamma = root + gamma slope_phi / (3 root)
    const T safe = select(root > 0.0, root, T{} + 1.0);
    const T slope = slope_phi - (4.0 / 3.0) * limit * y.hardening_modulus * (root + gamma * slope_phi / (3.0 * safe));
    const T f = phi - (2.0 / 3.0) * limit * limit;
    const T next = gamma - f / select(slope < 0.0, slope, T{} - 1.0);
    gamma = select(over > 0.0, select(next > 0.0, next, T{}), T{});
  }
  const T q_mean = 1.0 / (1.0 + k_mean * gamma), q_dev = 1.0 / (1.0 + two_mu * gamma);
  const T phi = part_mean * q_mean * q_mean + part_dev * q_dev * q_dev;
  p.strain = p.strain + gamma * square_root(phi * (2.0 / 3.0));
  const T lost_mean = (1.0 - q_mean) * mean, lost_dev = 1.0 - q_dev;  // none, to the bit, where it did not flow
  p.change.c11 = p.change.c11 + 2.0 * (lost_mean * c.c11 + lost_dev * d.c11);
  p.change.c22 = p.change.c22 + 2.0 * (lost_mean * c.c22 + lost_dev * d.c22);
  p.change.c12 = p.change.c12 + 2.0 * (lost_mean * c.c12 + lost_dev * d.c12);
  return over > 0.0;
}

/// Work [J/m^3] that the stress `s` at metric `c` does as the plastic metric comes to `a` by `flow`: the elastic energy
/// depends on C Abar^-1, so it is s : (C Abar^-1 flow) / 2, which is s : flow / 2 for elastic strains that are small
/// against 1. What hardening stores is part of it.
template <class T>
inline T plastic_work(const Sym2<T>& s, const Sym2<T>& c, const Sym2<T>& a, const Sym2<T>& flow) {
  const T inverse = 1.0 / determinant(a);
  // Abar^-1 flow, rows by columns
  const T k11 = (a.c22 * flow.c11 - a.c12 * flow.c12) * inverse, k12 = (a.c22 * flow.c12 - a.c12 * flow.c22) * inverse;
  const T k21 = (a.c11 * flow.c12 - a.c12 * flow.c11) * inverse, k22 = (a.c11 * flow.c22 - a.c12 * flow.c12) * inverse;
  return 0.5 * (s.c11 * (c.c11 * k11 + c.c12 * k21) + s.c22 * (c.c12 * k12 + c.c22 * k22) +
                s.c12 * (c.c11 * k12 + c.c12 * k22 + c.c12 * k11 + c.c22 * k21));
}

}  // namespace sunder::shell
