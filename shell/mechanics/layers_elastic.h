#pragma once
// Layers without memory: stress of the elastic law, integrated through the thickness; bending by layers or by Hooke.
#include "shell/mechanics/layer_memory.h"
#include "shell/mechanics/section.h"

namespace sunder::shell {

/// Adds moment and energy of linear bending: m = -t^3/12 H : (b - bbar), H^abcd = lambda' A^ab A^cd + mu (A^ac A^bd +
/// A^ad A^bc). A is the inverse of the reference metric. lambda' = 2 lambda mu / (lambda + 2 mu), or lambda under a law
/// that keeps the thickness.
template <class T, bool kEnergy>
inline void add_linear_bending(Resultants<T>& r, const Forms<T>& f, const ReferenceMetric<T>& ref, double bending,
                               const Elasticity& e) {
  const T inverse = 1.0 / determinant(ref.a);
  const T a11 = ref.a.c22 * inverse, a22 = ref.a.c11 * inverse, a12 = -ref.a.c12 * inverse;
  const T k11 = f.b.c11 - ref.b.c11, k22 = f.b.c22 - ref.b.c22, k12 = f.b.c12 - ref.b.c12;
  const T p11 = a11 * k11 + a12 * k12, p12 = a11 * k12 + a12 * k22, p21 = a12 * k11 + a22 * k12,
          p22 = a12 * k12 + a22 * k22;
  const double lambda = e.keeps_thickness() ? e.lambda : 2.0 * e.lambda * e.mu / (e.lambda + 2.0 * e.mu);
  const T mean = (bending * lambda) * (p11 + p22);
  const double twice = 2.0 * bending * e.mu;
  const T m11 = mean * a11 + twice * (p11 * a11 + p12 * a12), m22 = mean * a22 + twice * (p21 * a12 + p22 * a22),
          m12 = mean * a12 + twice * (p11 * a12 + p12 * a22);
  r.m = {r.m.c11 - m11, r.m.c22 - m22, r.m.c12 - m12};
  if constexpr (kEnergy) r.energy += 0.5 * (m11 * k11 + m22 * k22 + 2.0 * m12 * k12);
}

/// Resultants of the stress at C(zeta) = a - 2 zeta b against Abar(zeta) = abar - 2 zeta bbar. Out of line, so that
/// they are rounded alike for all callers.
template <class T, bool kEnergy>
[[gnu::noinline]] Resultants<T> integrate_layers(const Forms<T>& f, const ReferenceMetric<T>& ref, const Layers& layers,
                                                 const Elasticity& e) {
  Resultants<T> r{{T{}, T{}, T{}}, {T{}, T{}, T{}}, T{}};
  for (std::size_t l = 0; l < layers.zeta.size(); ++l) {
    const double z = layers.zeta[l], w = layers.weight[l];
    const Sym2<T> c = at_height(f.a, f.b, z);
    const Sym2<T> a = reference_at(ref, layers, l);
    const PlaneStress<T> p = plane_stress<T>(c, a, e);
    r.n.c11 += w * p.s.c11, r.n.c22 += w * p.s.c22, r.n.c12 += w * p.s.c12;
    r.m.c11 += (w * z) * p.s.c11, r.m.c22 += (w * z) * p.s.c22, r.m.c12 += (w * z) * p.s.c12;
    if constexpr (kEnergy) r.energy += w * plane_stress_energy<T>(p, c, a, e);
  }
  if (layers.bending > 0.0) add_linear_bending<T, kEnergy>(r, f, ref, layers.bending, e);
  return r;
}

/// The law of layers without memory, for both kernels.
struct ElasticLayers {
  static constexpr bool kRemembers = false, kFolds = false, kAdvances = false;
  static bool in_force(const LayerMemory&) { return true; }

  template <class Places>
  struct At {
    using T = typename Places::Value;
    const RowTables& t;

    const T* unbooked() const { return nullptr; }
    template <bool kEnergy, bool kRecord, class Mask>
    Resultants<T> resultants(const Forms<T>& f, const ReferenceMetric<T>& ref, const Mask&) const {
      return integrate_layers<T, kEnergy>(f, ref, t.layers, t.elasticity);
    }
    template <bool kEnergy, bool kRecord, class Mask>
    T keep(const Forms<T>&, const Mask&, const Mask&, const T&, double&) const {
      return T{};
    }
  };
  template <class Places>
  static At<Places> at(const Places& p, const LayerMemory&) {
    return {p.t};
  }
  static void book_rows(const LayerMemory&, double) {}
  static void book_points(const LayerMemory&, double) {}
};

}  // namespace sunder::shell
