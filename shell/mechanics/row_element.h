#pragma once
// Forces of one row of elements, for either degree. Each degree is compiled by itself (row_quadratic.cpp,
// row_cubic.cpp): what the compiler inlines in one kernel then does not depend on the other.
#include <algorithm>
#include <array>
#include <vector>

#include "shell/mechanics/layers.h"
#include "shell/mechanics/row_contract.h"
#include "shell/mechanics/row_force.h"

namespace sunder::shell {

/// Sums of a row: elastic energy [J], and the energy that its layers booked [J].
struct RowSums {
  double energy = 0.0, booked = 0.0;
};
using RowFunction = RowSums (*)(const RowTables&, const double*, const SurfaceStress&, const LayerMemory&, int,
                                double*);
/// What a kernel is compiled for: shells of one thickness pay nothing for those whose thickness varies.
enum class RowShape { kPolynomial, kRational, kVarying };
RowFunction quadratic_row(bool rational, const LayerMemory& memory, bool energy, bool stress);
RowFunction cubic_row(bool rational, const LayerMemory& memory, bool energy, bool stress);
RowFunction varying_row(int degree, const LayerMemory& memory, bool energy, bool stress);

namespace {

// A pack of elements at one Gauss point along u and v.
struct RowPack {
  const RowTables& t;
  int block, e;  // first lane

  const double* metric() const { return &t.metric[t.at(block, kMetricFields, 0, e)]; }
  ReferenceMetric<Pack> reference() const {
    const double* m = metric();
    const auto field = [&](int k) { return load<Pack>(m + k * t.lanes); };
    return {{field(kA11), field(kA22), field(kA12)}, {field(kB11), field(kB22), field(kB12)}};
  }
};

// Basis functions along u at a Gauss point: [k][lane].
struct BasisAlongU {
  const double *value, *first, *second;
};

// Memory of a row, reused. Forces on the control points of an element, three or four along u, stand apart in `parts`:
// [k][value, first, second in v][x y z][element], so that a pack is stored where the next Gauss point loads it, and no
// load straddles two stores. Around a row there are only zeros.
struct RowBuffer {
  double *c, *q, *parts;  // c: [value, first, second in v][x y z][stride] of the net; q: the same of forces
  std::size_t reach;      // of one field of parts
};
template <int kSupport>
RowBuffer row_buffer(const RowTables& t) {
  thread_local std::vector<double> buffer;
  thread_local int cleared_for = 0;  // rows of other lengths may have the same stride, and leave forces behind
  const std::size_t reach = static_cast<std::size_t>(t.stride) + 2 * kLanes;
  const std::size_t needed = static_cast<std::size_t>(18) * t.stride + 9 * kSupport * reach;
  if (buffer.size() != needed || cleared_for != t.lanes) buffer.assign(needed, 0.0), cleared_for = t.lanes;
  double* const c = buffer.data();
  return {c, c + 9 * t.stride, c + 18 * t.stride + kLanes, reach};
}

// Contracts the net of element row `f` with the basis `by` along v, its first and its second derivative.
template <int kSupport>
[[gnu::always_inline]] inline void contract_along_v(const RowTables& t, const double* x, int f, const double* by,
                                                    double* c) {
  const int stride = t.stride;
  for (int d = 0; d < 3; ++d) {
    const double* x0 = x + static_cast<std::size_t>(d) * t.component_stride + static_cast<std::size_t>(f) * stride;
    const double *x1 = x0 + stride, *x2 = x1 + stride;
    double *c0 = c + d * stride, *c1 = c + (3 + d) * stride, *c2 = c + (6 + d) * stride;
    for (int i = 0; i < stride; i += kLanes) {
      const Pack p0 = load<Pack>(x0 + i), p1 = load<Pack>(x1 + i), p2 = load<Pack>(x2 + i);
      const auto put = [&](double* to, const double* n) {
        const Pack three = n[0] * p0 + n[1] * p1 + n[2] * p2;
        if constexpr (kSupport == 3)
          store<Pack>(to + i, three);
        else
          store<Pack>(to + i, three + n[3] * load<Pack>(x2 + stride + i));
      };
      put(c0, by), put(c1, by + kSupport), put(c2, by + 2 * kSupport);
    }
  }
}

// The denominator of a rational patch at a pack, and its derivatives.
using Denominator = std::array<Pack, kRationalFields>;
[[gnu::always_inline]] inline Denominator denominator_at(const RowPack& p) {
  Denominator w;
  const double* den = &p.t.denominator[p.t.at(p.block, kRationalFields, 0, 0)];
  for (int i = 0; i < kRationalFields; ++i) w[i] = load<Pack>(den + i * p.t.lanes + p.e);
  return w;
}

// Contracts further along u: derivatives of the surface. On rational patches by the quotient rule.
template <int kSupport, bool kRational>
[[gnu::always_inline]] inline Derivatives<Pack> derivatives_at(const RowPack& at, const BasisAlongU& n, const double* c,
                                                               [[maybe_unused]] const Denominator& w) {
  const int stride = at.t.stride, lanes = at.t.lanes, e = at.e;
  Derivatives<Pack> d;
  d.u = contract3<kSupport>(n.first, lanes, c, stride, e);
  d.v = contract3<kSupport>(n.value, lanes, c + 3 * stride, stride, e);
  d.uu = contract3<kSupport>(n.second, lanes, c, stride, e);
  d.vv = contract3<kSupport>(n.value, lanes, c + 6 * stride, stride, e);
  d.uv = contract3<kSupport>(n.first, lanes, c + 3 * stride, stride, e);
  if constexpr (kRational) {
    const Vector<Pack> p = scaled(w[kInvW], contract3<kSupport>(n.value, lanes, c, stride, e));
    axpy(d.u, -w[kWu], p), axpy(d.v, -w[kWv], p);
    d.u = scaled(w[kInvW], d.u), d.v = scaled(w[kInvW], d.v);
    axpy(d.uu, -2.0 * w[kWu], d.u), axpy(d.uu, -w[kWuu], p), d.uu = scaled(w[kInvW], d.uu);
    axpy(d.vv, -2.0 * w[kWv], d.v), axpy(d.vv, -w[kWvv], p), d.vv = scaled(w[kInvW], d.vv);
    axpy(d.uv, -w[kWu], d.v), axpy(d.uv, -w[kWv], d.u), axpy(d.uv, -w[kWuv], p);
    d.uv = scaled(w[kInvW], d.uv);
  }
  return d;
}

// Transpose of the quotient rule, in reverse order: forces on the homogeneous derivatives, and `p` on the value.
[[gnu::always_inline]] inline void transpose_quotient(Derivatives<Pack>& g, Vector<Pack>& p, const Denominator& w) {
  g.uv = scaled(w[kInvW], g.uv), axpy(g.v, -w[kWu], g.uv), axpy(g.u, -w[kWv], g.uv), axpy(p, -w[kWuv], g.uv);
  g.vv = scaled(w[kInvW], g.vv), axpy(g.v, -2.0 * w[kWv], g.vv), axpy(p, -w[kWvv], g.vv);
  g.uu = scaled(w[kInvW], g.uu), axpy(g.u, -2.0 * w[kWu], g.uu), axpy(p, -w[kWuu], g.uu);
  g.u = scaled(w[kInvW], g.u), axpy(p, -w[kWu], g.u);
  g.v = scaled(w[kInvW], g.v), axpy(p, -w[kWv], g.v);
  p = scaled(w[kInvW], p);
}

// Multiplies second derivatives, or the forces on them, by the factor of the thickness.
[[gnu::always_inline]] inline void thicken(Derivatives<Pack>& d, const Pack& factor) {
  d.uu = scaled(factor, d.uu), d.vv = scaled(factor, d.vv), d.uv = scaled(factor, d.uv);
}

inline void keep_where(IntPack mask, Vector<Pack>& v) {
  v = {select(mask, v.x, Pack{}), select(mask, v.y, Pack{}), select(mask, v.z, Pack{})};
}

// `now` where `summed`, elsewhere the state at rest.
inline Sym2<Pack> rest_beyond(const IntPack& summed, const Sym2<Pack>& now, const Sym2<Pack>& rest) {
  return {select(summed, now.c11, rest.c11), select(summed, now.c22, rest.c22), select(summed, now.c12, rest.c12)};
}

// Factors from resultants to the stress of the faces.
struct FaceFactors {
  SectionFaces section;
  double of_n, of_m;
  explicit FaceFactors(const Layers& layers) : section(section_faces(layers)) {
    of_n = 1.0 / section.thickness, of_m = 6.0 / section.squared;
  }
  Sym2<Pack> face(const Resultants<Pack>& r, double side) const {
    const auto part = [&](const Pack& n, const Pack& m) { return n * of_n + side * (m * of_m); };
    return {part(r.n.c11, r.m.c11), part(r.n.c22, r.m.c22), part(r.n.c12, r.m.c12)};
  }
};

// Takes the stress of the faces into the running mean. Other lanes keep theirs, but folded ones of `own` lose it.
template <bool kFolds>
[[gnu::always_inline]] inline void record_faces(const RowPack& at, const SurfaceStress& stress,
                                                const FaceStress<Pack>& faces, const IntPack& own,
                                                const IntPack& summed) {
  double* s = stress.values->data() + at.t.at(at.block, 6, 0, at.e);
  const Pack now[6] = {faces.low.c11, faces.low.c22, faces.low.c12, faces.high.c11, faces.high.c22, faces.high.c12};
  for (int i = 0; i < 6; ++i) {
    const Pack mean = load<Pack>(s + i * at.t.lanes);
    const Pack kept = kFolds ? select(own, Pack{}, mean) : mean;
    store<Pack>(s + i * at.t.lanes, select(summed, mean + stress.share * (now[i] - mean), kept));
  }
}

// What a row sums beside forces.
struct PackSums {
  Pack energy{};
  double retained = 0.0, booked = 0.0;
};

// Forces of a pack, conjugate to the derivatives `d`; zero where nothing is summed. `own` is false for padding, empty
// spans and points that a crack has touched.
template <bool kEnergy, bool kStress, class Law>
[[gnu::always_inline]] inline Derivatives<Pack> pack_forces(const RowPack& at, const Derivatives<Pack>& d,
                                                            const Pack& area, const IntPack& own,
                                                            const SurfaceStress& stress, const FaceFactors& factors,
                                                            const LayerMemory& memory, PackSums& sums) {
  const ReferenceMetric<Pack> ref = at.reference();
  Forms<Pack> forms = surface_forms(d);
  IntPack summed = own;
  auto law = Law::at(RowPlaces{at.t, at.block, at.e}, memory);
  Resultants<Pack> r;
  const auto others_at_rest = [&] {  // lanes that are not summed would force the slow branch of large strain on all
    if (any(~summed)) forms.a = rest_beyond(summed, forms.a, ref.a), forms.b = rest_beyond(summed, forms.b, ref.b);
  };
  if constexpr (Law::kAdvances) {
    others_at_rest();
    if (!law.template try_elastic<kEnergy, kStress>(forms, ref, factors.section, r)) {
      summed = own & bears(forms, ref, at.t.layers);
      others_at_rest();
      // where all bear, nothing has changed, and layers are not surely elastic
      r = any(own & ~summed) ? law.template resultants<kEnergy, kStress>(forms, ref, summed)
                             : law.template yielding_resultants<kEnergy, kStress>(forms, ref, summed);
    }
  } else {
    if constexpr (Law::kFolds) summed = own & bears(forms, ref, at.t.layers);
    others_at_rest();
    r = law.template resultants<kEnergy, kStress>(forms, ref, summed);
  }
  if constexpr (Law::kRemembers) {
    if constexpr (!Law::kFolds) summed &= law.sound(forms, ref);
    if constexpr (kEnergy || kStress || Law::kAdvances) {
      [[maybe_unused]] const Pack retained = law.template keep<kEnergy, kStress>(forms, own, summed, area, sums.booked);
      if constexpr (kEnergy)
        for (int i = 0; i < kLanes; ++i) sums.retained += retained[i];
    }
  }
  if constexpr (kEnergy) {
    Pack stored = r.energy;
    if (const Pack* more = law.unbooked()) stored += *more;
    sums.energy += select(summed, area * stored, Pack{});
  }
  if constexpr (kStress) {
    if constexpr (Law::kFolds)
      record_faces<true>(at, stress, law.faces, own, summed);
    else
      record_faces<false>(at, stress, {factors.face(r, -1.0), factors.face(r, 1.0)}, own, summed);
  }
  Derivatives<Pack> g = section_forces(d, forms, r, area);
  keep_where(summed, g.u), keep_where(summed, g.v), keep_where(summed, g.uu), keep_where(summed, g.vv);
  keep_where(summed, g.uv);
  return g;
}

// Adds forces on derivatives to those on the control points of each element, or overwrites them.
template <int kSupport, bool kRational>
[[gnu::always_inline]] inline void add_parts(double* parts, std::size_t reach, const BasisAlongU& basis, int lanes,
                                             int e, bool add, const Derivatives<Pack>& g, const Vector<Pack>& p) {
  const Pack gu[3] = {g.u.x, g.u.y, g.u.z}, gv[3] = {g.v.x, g.v.y, g.v.z}, guu[3] = {g.uu.x, g.uu.y, g.uu.z};
  const Pack gvv[3] = {g.vv.x, g.vv.y, g.vv.z}, guv[3] = {g.uv.x, g.uv.y, g.uv.z}, gp[3] = {p.x, p.y, p.z};
  for (int k = 0; k < kSupport; ++k) {
    const Pack n = load<Pack>(basis.value + k * lanes + e), n1 = load<Pack>(basis.first + k * lanes + e),
               n2 = load<Pack>(basis.second + k * lanes + e);
    for (int i = 0; i < 3; ++i) {
      double* own = parts + (9 * k + i) * reach + e;
      Pack s0 = n1 * gu[i] + n2 * guu[i], s1 = n * gv[i] + n1 * guv[i], s2 = n * gvv[i];
      if constexpr (kRational) s0 += n * gp[i];
      if (add) s0 += load<Pack>(own), s1 += load<Pack>(own + 3 * reach), s2 += load<Pack>(own + 6 * reach);
      store<Pack>(own, s0), store<Pack>(own + 3 * reach, s1), store<Pack>(own + 6 * reach, s2);
    }
  }
}

// Sums the parts along u, and adds them to the control rows with the basis `by` along v: the transpose of
// contract_along_v.
template <int kSupport>
[[gnu::always_inline]] inline void scatter_along_v(const RowTables& t, const RowBuffer& buffer, const double* by,
                                                   double* out) {
  const int stride = t.stride;
  const std::size_t reach = buffer.reach;
  double* const q = buffer.q;
  for (int k = 0; k < 9; ++k) {
    const double *p0 = buffer.parts + k * reach, *p1 = p0 + 9 * reach - 1, *p2 = p0 + 18 * reach - 2;
    for (int i = 0; i < stride; i += kLanes) {
      Pack sum = load<Pack>(p0 + i) + load<Pack>(p1 + i) + load<Pack>(p2 + i);
      if constexpr (kSupport == 4) sum += load<Pack>(p0 + 27 * reach - 3 + i);
      store<Pack>(q + k * stride + i, sum);
    }
  }
  for (int j = 0; j < kSupport; ++j)
    for (int d = 0; d < 3; ++d) {
      double* o = out + (j * 3 + d) * stride;
      const double *q0 = q + d * stride, *q1 = q + (3 + d) * stride, *q2 = q + (6 + d) * stride;
      for (int i = 0; i < stride; i += kLanes)
        store<Pack>(o + i, load<Pack>(o + i) + by[j] * load<Pack>(q0 + i) + by[kSupport + j] * load<Pack>(q1 + i) +
                               by[2 * kSupport + j] * load<Pack>(q2 + i));
    }
}

// Of a block's stress, [6][lane].
inline bool any_tension_above(const double* stress, int lanes, double limit) {
  Pack most{};
  for (int e = 0; e < lanes; e += kLanes)
    for (const int face : {0, 3}) {
      const auto field = [&](int k) { return load<Pack>(stress + (face + k) * lanes + e); };
      const Pack tension = most_tension(field(0), field(1), field(2));
      most = select(tension > most, tension, most);
    }
  return any(most > limit);
}

template <int kSupport, RowShape kShape, bool kEnergy, bool kStress, class Law>
RowSums element_row(const RowTables& t, const double* x, const SurfaceStress& stress, const LayerMemory& memory, int f,
                    double* out) {
  constexpr bool kRational = kShape != RowShape::kPolynomial;
  const int lanes = t.lanes;
  const RowBuffer buffer = row_buffer<kSupport>(t);
  std::fill(out, out + 3 * kSupport * t.stride, 0.0);
  double* const parts = buffer.parts;  // in registers: stores of packs would make the compiler load it again
  const std::size_t reach = buffer.reach;
  const FaceFactors factors(t.layers);
  PackSums sums;
  for (int b = 0; b < t.gauss; ++b) {
    const int row = f * t.gauss + b;
    const double* by = &t.basis_v[static_cast<std::size_t>(row) * 3 * kSupport];
    contract_along_v<kSupport>(t, x, f, by, buffer.c);
    for (int a = 0; a < t.gauss; ++a) {
      const int block = row * t.gauss + a;
      const double* value = &t.basis_u[static_cast<std::size_t>(a) * 3 * kSupport * lanes];
      const BasisAlongU basis{value, value + kSupport * lanes, value + 2 * kSupport * lanes};
      for (int e = 0; e < lanes; e += kLanes) {
        const RowPack at{t, block, e};
        const double* metric = at.metric();
        const Pack area = load<Pack>(metric + kArea * lanes);
        // the next Gauss point's numbers, which no prefetcher of hardware expects: seven streams that change every row
        for (int k = 0; k < kMetricFields; ++k) __builtin_prefetch(metric + (kMetricFields + k) * lanes);
        const IntPack own = area > 0.0;
        if (!any(own)) {
          for (int k = 0; k < 9 * kSupport && a == 0; ++k) store<Pack>(parts + k * reach + e, Pack{});
          continue;
        }
        Denominator w;
        if constexpr (kRational) w = denominator_at(at);
        Derivatives<Pack> d = derivatives_at<kSupport, kRational>(at, basis, buffer.c, w);
        [[maybe_unused]] Pack thick;
        if constexpr (kShape == RowShape::kVarying)
          thick = load<Pack>(&t.thickness[static_cast<std::size_t>(block) * lanes + e]), thicken(d, thick);
        Derivatives<Pack> g = pack_forces<kEnergy, kStress, Law>(at, d, area, own, stress, factors, memory, sums);
        if constexpr (kShape == RowShape::kVarying) thicken(g, thick);
        Vector<Pack> p{};
        if constexpr (kRational) transpose_quotient(g, p, w);
        add_parts<kSupport, kRational>(parts, reach, basis, lanes, e, a > 0, g, p);
      }
      if constexpr (kStress)
        if (stress.over)
          (*stress.over)[block] = any_tension_above(stress.values->data() + t.at(block, 6, 0, 0), lanes,
                                                    kSurelyBelow * (*stress.least)[block]);
    }
    scatter_along_v<kSupport>(t, buffer, by, out);
  }
  double sum = 0.0;
  for (int i = 0; i < kLanes; ++i) sum += sums.energy[i];
  return {sum - sums.retained, sums.booked};
}

template <int kSupport, RowShape kShape>
RowFunction row_of_shape(const LayerMemory& memory, bool energy, bool stress) {
  return with_layers(memory, [&]<class Law>(Law) -> RowFunction {
    if (energy)
      return stress ? element_row<kSupport, kShape, true, true, Law> : element_row<kSupport, kShape, true, false, Law>;
    return stress ? element_row<kSupport, kShape, false, true, Law> : element_row<kSupport, kShape, false, false, Law>;
  });
}

template <int kSupport>
RowFunction row_function(bool rational, const LayerMemory& memory, bool energy, bool stress) {
  return rational ? row_of_shape<kSupport, RowShape::kRational>(memory, energy, stress)
                  : row_of_shape<kSupport, RowShape::kPolynomial>(memory, energy, stress);
}

}  // namespace
}  // namespace sunder::shell
