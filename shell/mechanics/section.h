#pragma once
// One point of the mid-surface: from tangents and second derivatives to strain, and from resultants to forces.
#include <cmath>

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

/// First and second derivatives of the surface [m/m], [1/m]; or the forces conjugate to them.
template <class T>
struct Derivatives {
  Vector<T> u, v, uu, vv, uv;
};

/// Resultants over the thickness per reference area, contravariant: n [N/m], m [N].
template <class T>
struct Resultants {
  Sym2<T> n, m;
  T energy;  // [J/m^2]; only where it is asked for
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
[[gnu::always_inline]] inline Sym2<T> reference_at(const ReferenceMetric<T>& ref, const Layers& layers,
                                                   std::size_t layer) {
  Sym2<T> a = at_height(ref.a, ref.b, layers.zeta[layer]);
  if (!layers.growth.empty()) {
    const double g = layers.growth[layer];
    a = {g * a.c11, g * a.c22, g * a.c12};
  }
  return a;
}

/// Vectors of the plane with the metric `c`, the first along the first axis: columns g1 = (g11, 0), g2 = (g12, g22).
/// They lead to orthonormal components and back.
struct PlaneBasis {
  double g11, g12, g22;
  explicit PlaneBasis(const Sym2<double>& c)
      : g11(std::sqrt(c.c11)), g12(c.c12 / g11), g22(std::sqrt(determinant(c)) / g11) {}
  /// Orthonormal components of a contravariant tensor, times `scale`.
  Sym2<double> push(const Sym2<double>& s, double scale) const {
    return {scale * (s.c11 * g11 * g11 + 2.0 * s.c12 * g11 * g12 + s.c22 * g12 * g12), scale * s.c22 * g22 * g22,
            scale * (s.c12 * g11 * g22 + s.c22 * g12 * g22)};
  }
  /// Orthonormal components of a covariant tensor.
  Sym2<double> pull(const Sym2<double>& e) const {
    const double i11 = 1.0 / g11, i22 = 1.0 / g22, i12 = -g12 * i11 * i22;  // the inverse, upper triangular
    return {i11 * i11 * e.c11, i12 * i12 * e.c11 + 2.0 * i12 * i22 * e.c12 + i22 * i22 * e.c22,
            i11 * (i12 * e.c11 + i22 * e.c12)};
  }
  /// Covariant components of a tensor with orthonormal components `e`.
  Sym2<double> lower(const Sym2<double>& e) const {
    return {g11 * g11 * e.c11, g12 * g12 * e.c11 + 2.0 * g12 * g22 * e.c12 + g22 * g22 * e.c22,
            g11 * (g12 * e.c11 + g22 * e.c12)};
  }
};

/// Stress at the lower and the upper face [Pa].
template <class T>
struct FaceStress {
  Sym2<T> low, high;
};

/// [-]: square of the share of area, and of length in any direction, below which a point bears no stress: a fifth.
/// numerical: laws of the material say nothing of so much compression, and the step would become short
constexpr double kCrushed = 0.04;

/// True if the metric `c` keeps more than the share above of the area of `a`, and of each length. What is drawn to
/// several times its length keeps its area while it is pressed to nothing across.
template <class T>
[[gnu::always_inline]] inline auto keeps_shape(const Sym2<T>& c, const Sym2<T>& a) {
  const T rest = determinant(a), mixed = c.c11 * a.c22 + c.c22 * a.c11 - 2.0 * c.c12 * a.c12;
  // the smaller eigenvalue of a^-1 c exceeds the share where det(c - share a) > 0
  const T now = determinant(c), across = mixed - kCrushed * rest;
  auto good = now > kCrushed * rest;
  good = good & (now > kCrushed * across);
  // a metric that is inside out in both directions has a positive determinant and a negative trace
  good = good & (c.c11 + c.c22 > 0.0);
  return good;
}

/// True if a point bears stress. A point that is squeezed to less than a fifth of its area or of a length bears none,
/// nor does one that is bent so sharply that a layer turns inside out. The test is made at the mid-surface and the
/// outer layers.
template <class T>
[[gnu::always_inline]] inline auto bears(const Forms<T>& f, const ReferenceMetric<T>& ref, const Layers& layers) {
  auto good = keeps_shape(f.a, ref.a);
  for (const double z : {layers.zeta.front(), layers.zeta.back()})
    good = good & keeps_shape(at_height(f.a, f.b, z), at_height(ref.a, ref.b, z));
  return good;
}

/// Forces conjugate to the derivatives, for reference area `area` [m^2]: -area (n^ab a_b + m^bc Gamma^a_bc n) on
/// x_,alpha, and +area m^ab n on x_,ab (12 counts twice).
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
