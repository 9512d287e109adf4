#pragma once
// One point of the mid-surface: from tangents and second derivatives to forces on them.
#include "shell/mechanics/plane_stress.h"
#include "shell/mechanics/plasticity.h"
#include "shell/mechanics/row_tables.h"

namespace sunder::shell {

template <class T>
struct Vector {
  T x, y, z;
};
template <class T>
inline T dot(const Vector<T>& a, const Vector<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// First and second derivatives of the surface; as forces: what is conjugate to them.
template <class T>
struct Derivatives {
  Vector<T> u, v, uu, vv, uv;
};

/// Resultants over the thickness per reference area, contravariant: n [N/m], m [N].
template <class T>
struct Resultants {
  Sym2<T> n, m;
  T energy;  // [J/m^2]; only where asked for
};

template <class T>
struct ReferenceMetric {
  Sym2<T> a, b;
};

/// Surface measures of the current state.
template <class T>
struct Forms {
  Vector<T> normal;
  Sym2<T> a, b;    // first and second fundamental form
  T inverse_area;  // of the tangents' parallelogram
};

template <class T>
inline Forms<T> surface_forms(const Derivatives<T>& d) {
  Forms<T> f;
  f.normal = {d.u.y * d.v.z - d.u.z * d.v.y, d.u.z * d.v.x - d.u.x * d.v.z, d.u.x * d.v.y - d.u.y * d.v.x};
  f.a = {dot(d.u, d.u), dot(d.v, d.v), dot(d.u, d.v)};
  const T inverse = 1.0 / square_root(determinant(f.a));
  f.normal = {f.normal.x * inverse, f.normal.y * inverse, f.normal.z * inverse};
  f.inverse_area = inverse;
  f.b = {dot(d.uu, f.normal), dot(d.vv, f.normal), dot(d.uv, f.normal)};
  return f;
}

/// Metric at height `z` off the mid-surface, linear in it: a - 2 z b.
template <class T>
inline Sym2<T> at_height(const Sym2<T>& a, const Sym2<T>& b, double z) {
  return {a.c11 - 2.0 * z * b.c11, a.c22 - 2.0 * z * b.c22, a.c12 - 2.0 * z * b.c12};
}

/// Reference metric of a layer.
template <class T>
inline Sym2<T> reference_at(const ReferenceMetric<T>& ref, const Layers& layers, std::size_t layer) {
  Sym2<T> a = at_height(ref.a, ref.b, layers.zeta[layer]);
  if (!layers.growth.empty()) {
    const double g = layers.growth[layer];
    a = {g * a.c11, g * a.c22, g * a.c12};
  }
  return a;
}

/// Moment and energy of linear bending: m = -t^3/12 H : (b - bbar), H^abcd = lambda' A^ab A^cd + mu (A^ac A^bd +
/// A^ad A^bc) with the reference metric's inverse A and lambda' = 2 lambda mu / (lambda + 2 mu) where the thickness
/// gives way.
template <class T, bool kEnergy>
inline void add_linear_bending(Resultants<T>& r, const Forms<T>& f, const ReferenceMetric<T>& ref, double bending,
                               const Elasticity& e) {
  const T inverse = 1.0 / determinant(ref.a);
  const T a11 = ref.a.c22 * inverse, a22 = ref.a.c11 * inverse, a12 = -ref.a.c12 * inverse;
  const T k11 = f.b.c11 - ref.b.c11, k22 = f.b.c22 - ref.b.c22, k12 = f.b.c12 - ref.b.c12;
  const T p11 = a11 * k11 + a12 * k12, p12 = a11 * k12 + a12 * k22, p21 = a12 * k11 + a22 * k12,
          p22 = a12 * k12 + a22 * k22;
  const double lambda = keeps_thickness(e.model) ? e.lambda : 2.0 * e.lambda * e.mu / (e.lambda + 2.0 * e.mu);
  const T mean = (bending * lambda) * (p11 + p22);
  const double twice = 2.0 * bending * e.mu;
  const T m11 = mean * a11 + twice * (p11 * a11 + p12 * a12), m22 = mean * a22 + twice * (p21 * a12 + p22 * a22),
          m12 = mean * a12 + twice * (p11 * a12 + p12 * a22);
  r.m = {r.m.c11 - m11, r.m.c22 - m22, r.m.c12 - m12};
  if constexpr (kEnergy) r.energy += 0.5 * (m11 * k11 + m22 * k22 + 2.0 * m12 * k12);
}

/// C(zeta) = a - 2 zeta b against Abar(zeta) = abar - 2 zeta bbar, integrated over the layers.
template <class T, bool kEnergy>
inline Resultants<T> integrate_layers(const Forms<T>& f, const ReferenceMetric<T>& ref, const Layers& layers,
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

/// Stress at the lower and the upper face [Pa].
template <class T>
struct FaceStress {
  Sym2<T> low, high;
};

/// U S U with U^2 = C: Kirchhoff's stress without the rotation, which is the true one where volume stays.
template <class T>
inline Sym2<T> unrotated_stress(const Sym2<T>& s, const Sym2<T>& c) {
  const T root = square_root(determinant(c)), inverse = 1.0 / square_root(c.c11 + c.c22 + 2.0 * root);
  const T u11 = (c.c11 + root) * inverse, u22 = (c.c22 + root) * inverse, u12 = c.c12 * inverse;
  const T a11 = u11 * s.c11 + u12 * s.c12, a12 = u11 * s.c12 + u12 * s.c22;  // U S
  const T a21 = u12 * s.c11 + u22 * s.c12, a22 = u12 * s.c12 + u22 * s.c22;
  return {a11 * u11 + a12 * u12, a21 * u12 + a22 * u22, a11 * u12 + a12 * u22};
}

/// Stress at the face, `half` the thickness off the middle, beyond the outermost layer at `z`: by the line through the
/// next one at `next`, or the layer's own where it `flowed`.
template <class T, class Mask>
inline Sym2<T> carried_on(const Sym2<T>& s, const Sym2<T>& beside, const Mask& flowed, double z, double next,
                          double half) {
  const double on = ((z < next ? -half : half) - z) / (z - next);
  const auto part = [&](const T& own, const T& other) { return select(flowed, own, own + on * (own - other)); };
  return {part(s.c11, beside.c11), part(s.c22, beside.c22), part(s.c12, beside.c12)};
}

/// Scaled down to von Mises' `limit` where it is beyond: a face yields before the layer below it, and the stress of the
/// strain energy is some per cent above that of Hooke's law, by which the layers return.
template <class T>
inline Sym2<T> within(const Sym2<T>& s, const T& limit) {
  const T square = s.c11 * s.c11 - s.c11 * s.c22 + s.c22 * s.c22 + 3.0 * s.c12 * s.c12;
  const T share = select(square > limit * limit, limit / square_root(square), T{} + 1.0);
  return {share * s.c11, share * s.c22, share * s.c12};
}

/// The same where layers yield. `plastic` has a state of each layer, which `kAdvance` moves on; `dissipated` gains the
/// plastic work per reference area [J/m^2] that this takes, or with `kEnergy` would take, by the mean of the stress now
/// and of that at the forms `last`, where they last moved on: what leapfrog's forces put in, to second order of the
/// step (null: by the stress now alone). `faces`, where it is asked for, gets the true stress of the outermost layers
/// (strains may be large), carried on to the face along the line through the next one as long as they are elastic: what
/// resultants tell is 1.5 times the yield stress in a section that yields all through.
template <class T, bool kEnergy, bool kAdvance>
inline Resultants<T> integrate_yielding_layers(const Forms<T>& f, const ReferenceMetric<T>& ref, const Layers& layers,
                                               const Elasticity& e, const Yielding& y, PlasticState<T>* plastic,
                                               T& dissipated, FaceStress<T>* faces = nullptr,
                                               const Forms<T>* last = nullptr) {
  Resultants<T> r{{T{}, T{}, T{}}, {T{}, T{}, T{}}, T{}};
  const std::size_t top = layers.zeta.size() - 1;
  double half = 0.0;
  for (const double w : layers.weight) half += 0.5 * w;
  Sym2<T> below{T{}, T{}, T{}};  // stress of the layer before
  decltype(return_to_yield<T>(*plastic, below, below, y)) flowed_low{};
  T limit_low{};
  for (std::size_t l = 0; l < layers.zeta.size(); ++l) {
    const double z = layers.zeta[l], w = layers.weight[l];
    const Sym2<T> c = at_height(f.a, f.b, z);
    const Sym2<T> a = reference_at(ref, layers, l);
    PlasticState<T> s = plastic[l];
    const auto with = [&](const Sym2<T>& change) {
      return Sym2<T>{a.c11 + change.c11, a.c22 + change.c22, a.c12 + change.c12};
    };
    const auto flowed = return_to_yield<T>(s, c, a, y);
    const Sym2<T> now = with(s.change);
    const PlaneStress<T> p = plane_stress<T>(c, now, e);
    r.n.c11 += w * p.s.c11, r.n.c22 += w * p.s.c22, r.n.c12 += w * p.s.c12;
    r.m.c11 += (w * z) * p.s.c11, r.m.c22 += (w * z) * p.s.c22, r.m.c12 += (w * z) * p.s.c12;
    if constexpr (kEnergy) r.energy += w * plane_stress_energy<T>(p, c, now, e);
    if constexpr (kAdvance || kEnergy) {
      const Sym2<T>& old = plastic[l].change;
      const Sym2<T> flow{s.change.c11 - old.c11, s.change.c22 - old.c22, s.change.c12 - old.c12};
      T work = plastic_work<T>(p.s, c, now, flow);
      if (last && any(flowed)) {
        const Sym2<T> before = at_height(last->a, last->b, z), from = with(old);
        work = 0.5 * (work + plastic_work<T>(plane_stress<T>(before, from, e).s, before, from, flow));
      }
      dissipated += w * work;
      if constexpr (kAdvance) plastic[l] = s;
    }
    if (!faces) continue;
    const Sym2<T> own = unrotated_stress<T>(p.s, c);
    const T limit = y.yield_stress + y.hardening_modulus * s.strain;
    if (l == 0) faces->low = own, flowed_low = flowed, limit_low = limit;
    if (l == 1)
      faces->low =
          within<T>(carried_on<T>(faces->low, own, flowed_low, layers.zeta[0], layers.zeta[1], half), limit_low);
    if (l == top)
      faces->high = within<T>(carried_on<T>(own, below, flowed, layers.zeta[top], layers.zeta[top - 1], half), limit);
    below = own;
  }
  return r;
}

/// A point squeezed to less than a fifth of its area, or bent so sharply that a layer turns inside out, has no stress:
/// it bears nothing. Tells by mid-surface and outer layers.
constexpr double kCrushed = 0.04;  // of the reference metric's determinant
template <class T>
inline auto bears(const Forms<T>& f, const ReferenceMetric<T>& ref, const Layers& layers) {
  auto good = determinant(f.a) > kCrushed * determinant(ref.a);
  for (const double z : {layers.zeta.front(), layers.zeta.back()}) {
    const Sym2<T> c = at_height(f.a, f.b, z);
    const Sym2<T> a = at_height(ref.a, ref.b, z);
    // a metric with a negative trace is inside out twice over, and its determinant positive
    good = good & (determinant(c) > kCrushed * determinant(a)) & (c.c11 + c.c22 > 0.0);
  }
  return good;
}

/// Forces conjugate to the derivatives, for reference area `area`:
/// on x_,alpha: -area (n^ab a_b + m^bc Gamma^a_bc n), on x_,ab: +area m^ab n (12 counted twice).
template <class T>
inline Derivatives<T> section_forces(const Derivatives<T>& d, const Forms<T>& f, const Resultants<T>& r,
                                     const T& area) {
  const T inverse = f.inverse_area * f.inverse_area;
  const T i11 = f.a.c22 * inverse, i22 = f.a.c11 * inverse, i12 = -f.a.c12 * inverse;
  // w = m^bc x_,bc, so m^bc Gamma^a_bc = w . a^a
  const Vector<T> w{r.m.c11 * d.uu.x + r.m.c22 * d.vv.x + 2.0 * r.m.c12 * d.uv.x,
                    r.m.c11 * d.uu.y + r.m.c22 * d.vv.y + 2.0 * r.m.c12 * d.uv.y,
                    r.m.c11 * d.uu.z + r.m.c22 * d.vv.z + 2.0 * r.m.c12 * d.uv.z};
  const T wu = dot(w, d.u), wv = dot(w, d.v);
  const T k1 = i11 * wu + i12 * wv, k2 = i12 * wu + i22 * wv;
  const Vector<T>& n = f.normal;
  const T h11 = area * r.m.c11, h22 = area * r.m.c22, h12 = 2.0 * area * r.m.c12;
  Derivatives<T> g;
  g.u = {-area * (r.n.c11 * d.u.x + r.n.c12 * d.v.x + k1 * n.x), -area * (r.n.c11 * d.u.y + r.n.c12 * d.v.y + k1 * n.y),
         -area * (r.n.c11 * d.u.z + r.n.c12 * d.v.z + k1 * n.z)};
  g.v = {-area * (r.n.c12 * d.u.x + r.n.c22 * d.v.x + k2 * n.x), -area * (r.n.c12 * d.u.y + r.n.c22 * d.v.y + k2 * n.y),
         -area * (r.n.c12 * d.u.z + r.n.c22 * d.v.z + k2 * n.z)};
  g.uu = {h11 * n.x, h11 * n.y, h11 * n.z};
  g.vv = {h22 * n.x, h22 * n.y, h22 * n.z};
  g.uv = {h12 * n.x, h12 * n.y, h12 * n.z};
  return g;
}

}  // namespace sunder::shell
