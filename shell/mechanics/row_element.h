#pragma once
// Forces of one row of elements, for either degree. Each degree is compiled by itself (row_quadratic.cpp,
// row_cubic.cpp): what the compiler inlines in one kernel then does not depend on the other.
#include <algorithm>
#include <array>
#include <vector>

#include "shell/mechanics/row_contract.h"
#include "shell/mechanics/row_force.h"
#include "shell/mechanics/section.h"

namespace sunder::shell {

/// What a layer's stress depends on beside its strain.
enum class LayerLaw { kElastic, kYields, kWeakens, kIrreversibleDamage };  // the last without healing
struct RowMemory {
  const RowPlasticity* plastic = nullptr;
  const RowDamage* damage = nullptr;
};

using RowFunction = double (*)(const RowTables&, const double*, SurfaceStress, RowMemory, int, double*, double&);
RowFunction quadratic_row(bool rational, LayerLaw law, bool energy, bool stress);
RowFunction cubic_row(bool rational, LayerLaw law, bool energy, bool stress);

namespace {

constexpr int kMostYieldingLayers = 16;

inline void keep_where(IntPack mask, Vector<Pack>& v) {
  v = {select(mask, v.x, Pack{}), select(mask, v.y, Pack{}), select(mask, v.z, Pack{})};
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

// The damaged points of a pack: their resultants, and what they remember. `booked` gains what has healed, or was
// dissipated where nothing heals, `spared` what weakening spares of the energy; `summed` loses points that are crushed.
template <bool kEnergy, bool kStress, bool kHeals>
Resultants<Pack> weakened(const RowTables& t, const RowDamage& law, std::size_t first, const Pack& area,
                          const Forms<Pack>& forms, const ReferenceMetric<Pack>& ref, IntPack& summed, double& booked,
                          double& retained) {
  constexpr double kNever = 1e300;  // [Pa], strength of what is not watched
  constexpr bool kRemember = kEnergy || kStress;
  IntPack watched;
  for (int i = 0; i < kLanes; ++i) watched[i] = (*law.watched)[first + i] ? -1 : 0;
  const Pack strength = select(watched, load<Pack>(law.strength->data() + first), splat<Pack>(kNever));
  Pack damage[kMostLayers];
  if constexpr (!kHeals)
    for (int i = 0; i < kLanes; ++i)
      for (std::size_t l = 0; l < t.layers.zeta.size(); ++l)
        damage[l][i] = watched[i] ? (*law.points)[(*law.point_of)[first + i]].history[l] : 0.0;
  Resultants<Pack> lost;
  const Resultants<Pack> r = integrate_weakened_layers<Pack, kEnergy, kRemember, kHeals>(
      forms, ref, t.layers, t.elasticity, strength, law.brittleness, damage, lost);
  const IntPack sound = bears(forms, ref, t.layers);
  for (int i = 0; kRemember && i < kLanes; ++i) {
    if (!watched[i] || !summed[i]) continue;
    PointDamage& d = (*law.points)[(*law.point_of)[first + i]];
    if (!sound[i]) {
      d.fresh = true;
      continue;
    }
    const Loss loss = loss_of(forms, lost, i);
    if constexpr (kEnergy && kHeals) retained += d.retained + retained_since(d, loss, area[i]);
    if constexpr (kStress) {
      for (std::size_t l = 0; l < t.layers.zeta.size(); ++l) {
        d.now[l] = static_cast<float>(damage[l][i]);
        d.history[l] = std::max(d.history[l], d.now[l]);
      }
      booked += (kHeals ? keep : keep_worst)(d, loss, area[i]);
    }
    // what is not booked yet counts as stored
    if constexpr (kEnergy && !kHeals) retained += d.retained + retained_since(d, loss, area[i]);
  }
  summed &= sound | ~watched;
  return r;
}

template <int kSupport, bool kRational, bool kEnergy, bool kStress, LayerLaw kLaw>
double element_row(const RowTables& t, const double* x, SurfaceStress stress, RowMemory memory, int f, double* out,
                   double& booked) {
  constexpr bool kWeakens = kLaw == LayerLaw::kWeakens || kLaw == LayerLaw::kIrreversibleDamage;
  const int stride = t.stride, lanes = t.lanes;
  thread_local std::vector<double> buffer;
  // Forces on the control points of an element, three or four along u, apart: [k][value, first, second in v][x y z]
  // [element], so that a pack is stored where the next Gauss point loads it, and no load straddles two stores. Nothing
  // but zeros is ever around a row.
  const std::size_t reach = static_cast<std::size_t>(stride) + 2 * kLanes;
  const std::size_t needed = static_cast<std::size_t>(18) * stride + 9 * kSupport * reach;
  thread_local int cleared_for =
      0;  // rows of other lengths may have the same stride, and leave forces where none belong
  if (buffer.size() != needed || cleared_for != lanes) buffer.assign(needed, 0.0), cleared_for = lanes;
  double* c = buffer.data();   // [value, first, second in v][x y z][stride]
  double* q = c + 9 * stride;  // the same for forces
  double* parts = q + 9 * stride + kLanes;
  std::fill(out, out + 3 * kSupport * stride, 0.0);
  Pack energy{};
  [[maybe_unused]] double retained = 0.0;
  double thickness = 0.0;
  for (const double w : t.layers.weight) thickness += w;
  const double inverse_thickness = 1.0 / thickness, six_over_square = 6.0 / (thickness * thickness);
  for (int b = 0; b < t.gauss; ++b) {
    const int row = f * t.gauss + b;
    const double* by = &t.basis_v[static_cast<std::size_t>(row) * 3 * kSupport];
    for (int d = 0; d < 3; ++d) {
      const double* x0 = x + static_cast<std::size_t>(d) * t.plane + static_cast<std::size_t>(f) * stride;
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
    for (int a = 0; a < t.gauss; ++a) {
      const int block = row * t.gauss + a;
      const double* value = &t.basis_u[static_cast<std::size_t>(a) * 3 * kSupport * lanes];
      const double *first = value + kSupport * lanes, *second = value + 2 * kSupport * lanes;
      const double* metric = &t.metric[t.at(block, kMetricFields, 0, 0)];
      for (int e = 0; e < lanes; e += kLanes) {
        const Pack area = load<Pack>(metric + kArea * lanes + e);
        // the next Gauss point's numbers, which no prefetcher of hardware expects: seven streams that change every row
        for (int k = 0; k < kMetricFields; ++k) __builtin_prefetch(metric + (kMetricFields + k) * lanes + e);
        IntPack summed = area > 0.0;  // padding, empty spans and points that a crack has touched are not
        if (!any(summed)) {
          for (int k = 0; k < 9 * kSupport && a == 0; ++k) store<Pack>(parts + k * reach + e, Pack{});
          continue;
        }
        Derivatives<Pack> d;
        d.u = contract3<kSupport>(first, lanes, c, stride, e);
        d.v = contract3<kSupport>(value, lanes, c + 3 * stride, stride, e);
        d.uu = contract3<kSupport>(second, lanes, c, stride, e);
        d.vv = contract3<kSupport>(value, lanes, c + 6 * stride, stride, e);
        d.uv = contract3<kSupport>(first, lanes, c + 3 * stride, stride, e);
        std::array<Pack, kRationalFields> w;
        if constexpr (kRational) {  // quotient rule on the homogeneous sums
          const double* den = &t.denominator[t.at(block, kRationalFields, 0, 0)];
          for (int i = 0; i < kRationalFields; ++i) w[i] = load<Pack>(den + i * lanes + e);
          Vector<Pack> p = scaled(w[kInvW], contract3<kSupport>(value, lanes, c, stride, e));
          axpy(d.u, -w[kWu], p), axpy(d.v, -w[kWv], p);
          d.u = scaled(w[kInvW], d.u), d.v = scaled(w[kInvW], d.v);
          axpy(d.uu, -2.0 * w[kWu], d.u), axpy(d.uu, -w[kWuu], p), d.uu = scaled(w[kInvW], d.uu);
          axpy(d.vv, -2.0 * w[kWv], d.v), axpy(d.vv, -w[kWvv], p), d.vv = scaled(w[kInvW], d.vv);
          axpy(d.uv, -w[kWu], d.v), axpy(d.uv, -w[kWv], d.u), axpy(d.uv, -w[kWuv], p);
          d.uv = scaled(w[kInvW], d.uv);
        }
        const ReferenceMetric<Pack> ref{{load<Pack>(metric + kA11 * lanes + e), load<Pack>(metric + kA22 * lanes + e),
                                         load<Pack>(metric + kA12 * lanes + e)},
                                        {load<Pack>(metric + kB11 * lanes + e), load<Pack>(metric + kB22 * lanes + e),
                                         load<Pack>(metric + kB12 * lanes + e)}};
        Forms<Pack> forms = surface_forms(d);
        // plastic hinges fold more sharply than what is elastic, and stay so
        if constexpr (kLaw == LayerLaw::kYields) summed = summed & bears(forms, ref, t.layers);
        if (any(~summed)) {  // at rest: else what is not summed sends the whole pack the long way for large strain
          const auto at_rest = [&](const Sym2<Pack>& now, const Sym2<Pack>& rest) {
            return Sym2<Pack>{select(summed, now.c11, rest.c11), select(summed, now.c22, rest.c22),
                              select(summed, now.c12, rest.c12)};
          };
          forms.a = at_rest(forms.a, ref.a), forms.b = at_rest(forms.b, ref.b);
        }
        [[maybe_unused]] FaceStress<Pack> faces;
        const auto resultants = [&] {
          if constexpr (kLaw == LayerLaw::kYields) {
            const RowPlasticity* plastic = memory.plastic;
            const std::size_t layers = t.layers.zeta.size();
            double* own = plastic->states->data() + t.at(block, static_cast<int>(4 * layers), 0, e);
            PlasticState<Pack> states[kMostYieldingLayers];
            const auto each = [&](auto&& f) {
              for (std::size_t l = 0; l < layers; ++l) {
                double* m = own + 4 * l * lanes;
                PlasticState<Pack>& s = states[l];
                f(m, s.change.c11), f(m + lanes, s.change.c22), f(m + 2 * lanes, s.change.c12),
                    f(m + 3 * lanes, s.strain);
              }
            };
            each([](const double* m, Pack& v) { v = load<Pack>(m); });
            Pack lost{};
            FaceStress<Pack>* wanted = kStress ? &faces : nullptr;
            double* kept_forms = plastic->forms->data() + t.at(block, kFormFields, 0, e);
            const IntPack known = summed & (load<Pack>(kept_forms) > 0.0);
            Pack* const now[kFormFields] = {&forms.a.c11, &forms.a.c22, &forms.a.c12,
                                            &forms.b.c11, &forms.b.c22, &forms.b.c12};
            Forms<Pack> last{};
            Pack* const then[kFormFields] = {&last.a.c11, &last.a.c22, &last.a.c12,
                                             &last.b.c11, &last.b.c22, &last.b.c12};
            for (int k = 0; k < kFormFields; ++k) {
              double* kept = kept_forms + k * lanes;
              *then[k] = select(known, load<Pack>(kept), *now[k]);
              if (!plastic->advance) continue;
              // points that a crack has touched keep theirs here too
              const Pack other = select(area > 0.0, splat<Pack>(-1.0), load<Pack>(kept));
              store<Pack>(kept, select(summed, *now[k], other));
            }
            if (!plastic->advance) {
              Resultants<Pack> r = integrate_yielding_layers<Pack, kEnergy, false>(
                  forms, ref, t.layers, t.elasticity, plastic->law, states, lost, wanted, &last);
              if constexpr (kEnergy) r.energy += lost;  // what is not booked yet counts as stored
              return r;
            }
            const Resultants<Pack> r = integrate_yielding_layers<Pack, kEnergy, true>(
                forms, ref, t.layers, t.elasticity, plastic->law, states, lost, wanted, &last);
            each([&](double* m, const Pack& v) { store<Pack>(m, select(summed, v, load<Pack>(m))); });
            lost = select(summed, area * lost, Pack{});
            for (int i = 0; i < kLanes; ++i) booked += lost[i];
            return r;
          } else if constexpr (kWeakens) {
            const std::size_t first_point = static_cast<std::size_t>(block) * lanes + e;
            std::array<char, kLanes> watched;
            std::copy_n(memory.damage->watched->data() + first_point, kLanes, watched.data());
            if (watched != std::array<char, kLanes>{})
              return weakened<kEnergy, kStress, kLaw == LayerLaw::kWeakens>(t, *memory.damage, first_point, area, forms,
                                                                            ref, summed, booked, retained);
            return integrate_layers<Pack, kEnergy>(forms, ref, t.layers, t.elasticity);
          } else {
            return integrate_layers<Pack, kEnergy>(forms, ref, t.layers, t.elasticity);
          }
        };
        const Resultants<Pack> r = resultants();
        if constexpr (kEnergy) energy += select(summed, area * r.energy, Pack{});
        if constexpr (kStress) {
          double* s = stress.values->data() + t.at(block, 6, 0, e);
          if constexpr (kLaw != LayerLaw::kYields) {
            const auto face = [&](double side) {
              const auto part = [&](const Pack& n, const Pack& m) {
                return n * inverse_thickness + side * (m * six_over_square);
              };
              return Sym2<Pack>{part(r.n.c11, r.m.c11), part(r.n.c22, r.m.c22), part(r.n.c12, r.m.c12)};
            };
            faces = {face(-1.0), face(1.0)};
          }
          const Pack now[6] = {faces.low.c11,  faces.low.c22,  faces.low.c12,
                               faces.high.c11, faces.high.c22, faces.high.c12};
          for (int i = 0; i < 6; ++i) {
            const Pack mean = load<Pack>(s + i * lanes);
            const Pack kept = kLaw == LayerLaw::kYields ? select(area > 0.0, Pack{}, mean) : mean;  // folded: none
            store<Pack>(s + i * lanes, select(summed, mean + stress.share * (now[i] - mean), kept));
          }
        }
        Derivatives<Pack> g = section_forces(d, forms, r, area);
        keep_where(summed, g.u), keep_where(summed, g.v), keep_where(summed, g.uu), keep_where(summed, g.vv);
        keep_where(summed, g.uv);
        Vector<Pack> p{};
        if constexpr (kRational) {  // transpose of the quotient rule, in reverse order
          g.uv = scaled(w[kInvW], g.uv), axpy(g.v, -w[kWu], g.uv), axpy(g.u, -w[kWv], g.uv), axpy(p, -w[kWuv], g.uv);
          g.vv = scaled(w[kInvW], g.vv), axpy(g.v, -2.0 * w[kWv], g.vv), axpy(p, -w[kWvv], g.vv);
          g.uu = scaled(w[kInvW], g.uu), axpy(g.u, -2.0 * w[kWu], g.uu), axpy(p, -w[kWuu], g.uu);
          g.u = scaled(w[kInvW], g.u), axpy(p, -w[kWu], g.u);
          g.v = scaled(w[kInvW], g.v), axpy(p, -w[kWv], g.v);
          p = scaled(w[kInvW], p);
        }
        const Pack gu[3] = {g.u.x, g.u.y, g.u.z}, gv[3] = {g.v.x, g.v.y, g.v.z}, guu[3] = {g.uu.x, g.uu.y, g.uu.z};
        const Pack gvv[3] = {g.vv.x, g.vv.y, g.vv.z}, guv[3] = {g.uv.x, g.uv.y, g.uv.z}, gp[3] = {p.x, p.y, p.z};
        for (int k = 0; k < kSupport; ++k) {
          const Pack n = load<Pack>(value + k * lanes + e), n1 = load<Pack>(first + k * lanes + e),
                     n2 = load<Pack>(second + k * lanes + e);
          for (int i = 0; i < 3; ++i) {
            double* own = parts + (9 * k + i) * reach + e;
            Pack s0 = n1 * gu[i] + n2 * guu[i], s1 = n * gv[i] + n1 * guv[i], s2 = n * gvv[i];
            if constexpr (kRational) s0 += n * gp[i];
            if (a > 0) s0 += load<Pack>(own), s1 += load<Pack>(own + 3 * reach), s2 += load<Pack>(own + 6 * reach);
            store<Pack>(own, s0), store<Pack>(own + 3 * reach, s1), store<Pack>(own + 6 * reach, s2);
          }
        }
      }
      if constexpr (kStress)
        if (stress.over)
          (*stress.over)[block] = any_tension_above(stress.values->data() + t.at(block, 6, 0, 0), lanes,
                                                    kSurelyBelow * (*stress.least)[block]);
    }
    for (int k = 0; k < 9; ++k) {
      const double *p0 = parts + k * reach, *p1 = p0 + 9 * reach - 1, *p2 = p0 + 18 * reach - 2;
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
  double sum = 0.0;
  for (int i = 0; i < kLanes; ++i) sum += energy[i];
  if constexpr (kWeakens) sum -= retained;
  return sum;
}

template <int kSupport, bool kRational, LayerLaw kLaw>
RowFunction pick(bool energy, bool stress) {
  if (energy)
    return stress ? element_row<kSupport, kRational, true, true, kLaw>
                  : element_row<kSupport, kRational, true, false, kLaw>;
  return stress ? element_row<kSupport, kRational, false, true, kLaw>
                : element_row<kSupport, kRational, false, false, kLaw>;
}
template <int kSupport, bool kRational>
RowFunction pick(LayerLaw law, bool energy, bool stress) {
  return (law == LayerLaw::kYields               ? pick<kSupport, kRational, LayerLaw::kYields>
          : law == LayerLaw::kWeakens            ? pick<kSupport, kRational, LayerLaw::kWeakens>
          : law == LayerLaw::kIrreversibleDamage ? pick<kSupport, kRational, LayerLaw::kIrreversibleDamage>
                                                 : pick<kSupport, kRational, LayerLaw::kElastic>)(energy, stress);
}
template <int kSupport>
RowFunction row_function(bool rational, LayerLaw law, bool energy, bool stress) {
  return (rational ? pick<kSupport, true> : pick<kSupport, false>)(law, energy, stress);
}

}  // namespace
}  // namespace sunder::shell
