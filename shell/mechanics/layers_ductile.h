#pragma once
// Layers that yield and weaken: J2 plasticity under the weakened stress of Rankine damage. The full stress follows from
// the elastic strain alone, and sets the damage (eq. 9). A layer flows while its weakened stress reaches the yield
// stress. Along one axis the weakened stress never passes the strength, so a layer hardens up to the strength, and then
// softens without further flow: damage takes G_f there as in a layer that does not yield.
#include <optional>

#include "shell/mechanics/layers_weakening.h"
#include "shell/mechanics/layers_yielding.h"

namespace sunder::shell {

/// How a layer weakens.
struct Weakness {
  double strength = 0.0;     // [Pa]
  double brittleness = 0.0;  // H of eq. 9 [-]
  double least = 0.0;        // damage that it keeps [-]; with healing 0
};

/// Flow under the weakened stress, for a layer that the return by the full stress takes beyond its yield stress. Takes
/// the state `old`, the metric `c`, the rest metric `a`, and the elastic strain `before` of the last substep,
/// covariant. The elastic strain goes straight from there to the trial strain, and stops where the stress reaches the
/// strength: beyond it the layer bears less, and does not flow. Flow lasts until the weakened stress is at the yield
/// stress. Its direction is that of the weakened stress, which has the axes of the full one. Nothing is returned where
/// the full stress stays below the strength: the return by the full stress holds there.
std::optional<PlasticState<double>> flow_while_weakened(const PlasticState<double>& old, const Sym2<double>& c,
                                                        const Sym2<double>& a, const Sym2<double>& before,
                                                        const Elasticity& e, const Yielding& y, const Weakness& w);

/// What integrate_ductile_layers() takes and gives beside resultants.
template <class T>
struct DuctileSection {
  const Layers& layers;
  const Elasticity& elasticity;
  const Yielding& yielding;
  double brittleness;
  T strength;                      // [Pa]
  PointDamage* const* points;      // [lane]; null: the lane is not watched
  const LastForms<T>& last;        // forms of the last substep
  PlasticState<T>* plastic;        // in and, if it advances, out: [layer]
  T* damage;                       // out: [layer]; without healing it holds the least damage on entry
  T work{};                        // out: plastic work of the weakened stress [J/m^2]
  T lost_flow{};                   // out: that of the removed stress, less its share of missed_energy() [J/m^2]
  Resultants<T> lost{};            // out: of the removed stress
  FaceStress<T>* faces = nullptr;  // out: true weakened stress of the outermost layers
};

/// Share of S : E that the removed stress has, at metric `c` and reference metric `a`.
template <class T>
inline T removed_share(const Sym2<T>& removed, const Sym2<T>& full, const Sym2<T>& c, const Sym2<T>& a) {
  const auto work = [&](const Sym2<T>& s) {
    return s.c11 * (c.c11 - a.c11) + s.c22 * (c.c22 - a.c22) + 2.0 * s.c12 * (c.c12 - a.c12);
  };
  const T share = largest<T>(work(removed) / largest<T>(work(full), splat<T>(1e-300)), T{});
  return select(share < 1.0, share, splat<T>(1.0));  // near rest round-off may exceed 1
}

/// Replaces the lanes of `s` that flow and weaken, from the old state of the layer.
template <bool kHeals, class T, class Mask>
inline void flow_of_lanes(const DuctileSection<T>& in, std::size_t layer, const Mask& flowed, const Sym2<T>& c,
                          const Sym2<T>& a, const Sym2<T>& c_before, PlasticState<T>& s) {
  const auto of_lane = [](const Sym2<T>& v, int i) {
    return Sym2<double>{lane_of(v.c11, i), lane_of(v.c22, i), lane_of(v.c12, i)};
  };
  const PlasticState<T>& old = in.plastic[layer];
  for (int i = 0; i < lanes<T>(); ++i) {
    if (!lane_of(flowed, i) || !in.points[i]) continue;
    const PlasticState<double> from{of_lane(old.change, i), lane_of(old.strain, i)};
    const Sym2<double> rest = of_lane(a, i), then = of_lane(c_before, i);
    const Sym2<double> before{0.5 * (then.c11 - rest.c11 - from.change.c11),
                              0.5 * (then.c22 - rest.c22 - from.change.c22),
                              0.5 * (then.c12 - rest.c12 - from.change.c12)};
    const Weakness w{lane_of(in.strength, i), in.brittleness, kHeals ? 0.0 : lane_of(in.damage[layer], i)};
    const auto to = flow_while_weakened(from, of_lane(c, i), rest, before, in.elasticity, in.yielding, w);
    if (!to) continue;
    set_lane(s.change.c11, i, to->change.c11), set_lane(s.change.c22, i, to->change.c22);
    set_lane(s.change.c12, i, to->change.c12), set_lane(s.strain, i, to->strain);
  }
}

/// Stress of the full material at a metric `c` and a plastic metric `a`.
template <class T>
struct FullStress {
  const PlaneStress<T>& p;
  const Sym2<T>&c, &a;
};

/// What the full material stores more in a step than the trapezoidal rule says, its flow `flow` taken off [J/m^3]: an
/// error of third order. A layer that has torn may be stretched tenfold and flow by a multiple of its plastic metric as
/// it is pressed across. The full stress is then large, and its error a multiple of all that the layer ever stored,
/// although the layer bears next to nothing.
template <class T>
[[gnu::noinline]] T missed_energy(const FullStress<T>& now, const FullStress<T>& before, const T& flow,
                                  const Elasticity& e) {
  const Sym2<T>&s = now.p.s, &t = before.p.s;
  const T work = 0.25 * ((s.c11 + t.c11) * (now.c.c11 - before.c.c11) + (s.c22 + t.c22) * (now.c.c22 - before.c.c22) +
                         2.0 * ((s.c12 + t.c12) * (now.c.c12 - before.c.c12)));
  return plane_stress_energy<T>(now.p, now.c, now.a, e) - plane_stress_energy<T>(before.p, before.c, before.a, e) -
         work + flow;
}

/// Whether damage weakened a layer of any lane in the last substep.
template <class T>
inline bool was_weakened(const DuctileSection<T>& in, std::size_t layer) {
  for (int i = 0; i < lanes<T>(); ++i)
    if (in.points[i] && in.points[i]->now[layer] > 0.0f) return true;
  return false;
}

/// Resultants of layers that yield and weaken. `kAdvance` replaces the plastic states. With `kBooks` the work and the
/// resultants of the removed stress are summed, as in integrate_yielding_layers() and integrate_weakened_layers().
template <class T, bool kEnergy, bool kAdvance, bool kBooks, bool kHeals>
inline Resultants<T> integrate_ductile_layers(const Forms<T>& f, const ReferenceMetric<T>& ref, DuctileSection<T>& in) {
  Resultants<T> r{{T{}, T{}, T{}}, {T{}, T{}, T{}}, T{}};
  const Layers& layers = in.layers;
  const Elasticity& e = in.elasticity;
  const std::size_t top = layers.zeta.size() - 1;
  const double half = half_height(layers);
  Sym2<T> below{T{}, T{}, T{}};  // stress of the previous layer
  decltype(in.strength > 0.0) own_low{};
  T limit_low{};
  const auto weakened = [&](PlaneStress<T>& p, const Sym2<T>& c, const T& least) {
    if constexpr (kHeals)
      return weaken<T>(p.s, c, volume_ratio<T>(p, e), in.strength, in.brittleness);
    else
      return weaken<T, false>(p.s, c, volume_ratio<T>(p, e), in.strength, in.brittleness, least);
  };
  const auto less = [](const Sym2<T>& x, const Sym2<T>& y) {
    return Sym2<T>{x.c11 - y.c11, x.c22 - y.c22, x.c12 - y.c12};
  };
  for (std::size_t l = 0; l <= top; ++l) {
    const double z = layers.zeta[l], w = layers.weight[l];
    const Sym2<T> c = at_height(f.a, f.b, z), before = at_height(in.last.forms.a, in.last.forms.b, z);
    const Sym2<T> a = reference_at(ref, layers, l);
    const auto with = [&](const Sym2<T>& change) {
      return Sym2<T>{a.c11 + change.c11, a.c22 + change.c22, a.c12 + change.c12};
    };
    PlasticState<T> s = in.plastic[l];
    const auto flowed = return_to_yield<T>(s, c, a, in.yielding);
    if (any(flowed)) flow_of_lanes<kHeals>(in, l, flowed, c, a, before, s);
    const Sym2<T> now = with(s.change);
    PlaneStress<T> p = plane_stress<T>(c, now, e);
    const PlaneStress<T> p_full = p;
    const Sym2<T> full = p.s;
    T energy{};
    if constexpr (kEnergy || (kBooks && !kHeals)) energy = plane_stress_energy<T>(p, c, now, e);
    if constexpr (kEnergy) r.energy += w * energy;
    [[maybe_unused]] const T least = in.damage[l];
    in.damage[l] = weakened(p, c, least);
    r.n.c11 += w * p.s.c11, r.n.c22 += w * p.s.c22, r.n.c12 += w * p.s.c12;
    r.m.c11 += (w * z) * p.s.c11, r.m.c22 += (w * z) * p.s.c22, r.m.c12 += (w * z) * p.s.c12;
    if constexpr (kBooks) {
      const Sym2<T> removed = less(full, p.s);
      in.lost.n.c11 += w * removed.c11, in.lost.n.c22 += w * removed.c22, in.lost.n.c12 += w * removed.c12;
      in.lost.m.c11 += (w * z) * removed.c11, in.lost.m.c22 += (w * z) * removed.c22;
      in.lost.m.c12 += (w * z) * removed.c12;
      if constexpr (!kHeals) in.lost.energy += w * energy * removed_share<T>(removed, full, c, now);
      const bool flows = any(flowed);
      const auto has_flowed = s.strain > 0.0;  // others weaken as by WeakeningLayers, to the last digit
      if (flows || (any(has_flowed) && (any(in.damage[l] > 0.0) || was_weakened<T>(in, l)))) {
        const Sym2<T>& old = in.plastic[l].change;
        const Sym2<T> flow = less(s.change, old), from = with(old);
        PlaneStress<T> q = plane_stress<T>(before, from, e);
        const PlaneStress<T> q_full = q;
        const T damage = 0.5 * (in.damage[l] + weakened(q, before, least));
        T full_flow{};
        if (flows) {
          const T work = plastic_work<T>(p.s, c, now, flow) + plastic_work<T>(q.s, before, from, flow);
          const T lost =
              plastic_work<T>(removed, c, now, flow) + plastic_work<T>(less(q_full.s, q.s), before, from, flow);
          in.work += (0.5 * w) * select(in.last.known, work, T{});
          in.lost_flow += (0.5 * w) * lost, full_flow = 0.5 * (work + lost);
        }
        if (any(damage > 0.0)) {
          const T missed = missed_energy<T>({p_full, c, now}, {q_full, before, from}, full_flow, e);
          in.lost_flow -= select(has_flowed, w * damage * missed, T{});
        }
      }
    }
    if constexpr (kAdvance) in.plastic[l] = s;
    if (!in.faces) continue;
    const Sym2<T> own = unrotated_stress<T>(p.s, c);
    const T limit = in.yielding.yield_stress + in.yielding.hardening_modulus * s.strain;
    const decltype(own_low) bent =
        flowed | (in.damage[l] > 0.0);  // the stress is no straight line through the next layer
    if (l == 0) in.faces->low = own, own_low = bent, limit_low = limit;
    if (l == 1)
      in.faces->low =
          within<T>(extrapolated<T>(in.faces->low, own, own_low, layers.zeta[0], layers.zeta[1], half), limit_low);
    if (l == top)
      in.faces->high =
          within<T>(extrapolated<T>(own, below, bent, layers.zeta[top], layers.zeta[top - 1], half), limit);
    below = own;
  }
  return r;
}

/// The law of layers that yield and weaken, for both kernels. Points that are not watched yield as by YieldingLayers.
template <bool kHeals>
struct DuctileLayers {
  static constexpr bool kRemembers = true, kFolds = true, kAdvances = false;
  static bool in_force(const LayerMemory& m) {
    return YieldingLayers::in_force(m) && WeakeningLayers<kHeals>::in_force(m);
  }

  template <class Places>
  struct At {
    using T = typename Places::Value;
    YieldingLayers::At<Places> flow;
    typename WeakeningLayers<kHeals>::template At<T> weak;
    FaceStress<T> faces;  // only where stress is recorded
    T lost_flow{};        // plastic work that the removed stress would have done [J/m^2]
    At(const Places& p, const LayerMemory& m) : flow(p, *m.plastic), weak(WeakeningLayers<kHeals>::at(p, m)) {}
    At(const Places& p, const RowPlasticity& plastic, const typename WeakeningLayers<kHeals>::template At<T>& damage)
        : flow(p, plastic), weak(damage) {}

    /// Layers that have never flowed and are far below the yield stress weaken as by WeakeningLayers.
    template <bool kEnergy, bool kRecord, class Mask>
    Resultants<T> resultants(const Forms<T>& f, const ReferenceMetric<T>& ref, const Mask& summed) {
      if (!weak.any_watched) {
        const Resultants<T> r = flow.template resultants<kEnergy, kRecord>(f, ref, summed);
        faces = flow.faces;
        return r;
      }
      const Layers& layers = flow.places.t.layers;
      if (flow.never_flowed()) {
        const SectionFaces section = section_faces(layers);
        const FaceStress<T> full =
            linear_faces<T>(integrate_layers<T, false>(f, ref, layers, flow.places.t.elasticity), section);
        const Sym2<T> low = at_height(f.a, f.b, -section.half), high = at_height(f.a, f.b, section.half);
        const Yielding& y = flow.law.law;
        flow.elastic = !any(!(surely_elastic<T>(full.low, low, y) & surely_elastic<T>(full.high, high, y)));
        if (flow.elastic) {
          const Resultants<T> r = weak.template resultants<kEnergy, kRecord>(f, ref, summed);
          const FaceStress<T> s = linear_faces<T>(r, section);
          if constexpr (kRecord) faces = {unrotated_stress<T>(s.low, low), unrotated_stress<T>(s.high, high)};
          return r;
        }
      }
      if (flow.law.advance) return integrate<kEnergy, kRecord, true>(f, ref, summed);
      return integrate<kEnergy, kRecord, false>(f, ref, summed);
    }

    template <bool kEnergy, bool kRecord, bool kAdvance, class Mask>
    [[gnu::noinline]] Resultants<T> integrate(const Forms<T>& f, const ReferenceMetric<T>& ref, const Mask& summed) {
      const LastForms<T> last = load(f, summed);
      DuctileSection<T> section{flow.places.t.layers, flow.places.t.elasticity, flow.law.law, weak.brittleness,
                                weak.strength,        weak.points.data(),       last,         flow.states,
                                weak.damage};
      if constexpr (kRecord) section.faces = &faces;
      constexpr bool kBooks = kEnergy || kRecord || kAdvance;
      const Resultants<T> r = integrate_ductile_layers<T, kEnergy, kAdvance, kBooks, kHeals>(f, ref, section);
      flow.work = section.work, weak.lost = section.lost, lost_flow = section.lost_flow;
      return r;
    }

    const T* unbooked() const { return flow.unbooked(); }

    /// Keeps both states. Damage loses the work of the removed stress on the elastic strain: that on the whole strain,
    /// as WeakeningLayers counts, less what would have flowed away.
    template <bool kEnergy, bool kRecord, class Mask>
    T keep(const Forms<T>& f, const Mask& own, const Mask& sound, const T& area, double& booked) {
      double unused = 0.0;
      flow.template keep<kEnergy, kRecord>(f, own, sound, area,
                                           flow.law.sums ? flow.law.sums[flow.places.sum_slot()] : unused);
      T late{};
      for (int i = 0; i < lanes<T>(); ++i) {
        PointDamage* d = weak.points[i];
        if (!weak.any_watched || !d || !lane_of(own, i) || !lane_of(sound, i) || d->fresh) continue;
        const double off = lane_of(area, i) * lane_of(lost_flow, i);
        if constexpr (kRecord)
          d->retained -= off;
        else
          set_lane(late, i, off);
      }
      T retained = weak.template keep<kEnergy, kRecord>(f, own, sound, area, booked);
      retained = retained - late;
      return retained;
    }

    // Loads the states. Returns the previous forms; those of lanes that have none, or are not `summed`, are `f`.
    template <class Mask>
    LastForms<T> load(const Forms<T>& f, const Mask& summed) {
      const Places& places = flow.places;
      flow.load_states();
      if constexpr (!kHeals)
        for (int i = 0; i < lanes<T>(); ++i)
          for (std::size_t l = 0; l < places.t.layers.zeta.size(); ++l)
            set_lane(weak.damage[l], i, weak.points[i] ? weak.points[i]->history[l] : 0.0);
      return flow.last_forms(f, summed);
    }
  };

  template <class Places>
  static At<Places> at(const Places& p, const LayerMemory& m) {
    return At<Places>(p, m);
  }
  static void book_rows(const LayerMemory& m, double damage) { WeakeningLayers<kHeals>::book_rows(m, damage); }
  static void book_points(const LayerMemory& m, double damage) { WeakeningLayers<kHeals>::book_points(m, damage); }
};

/// True where layers yield and weaken: both memories are there.
inline bool is_ductile(const LayerMemory& m) {
  return DuctileLayers<true>::in_force(m) || DuctileLayers<false>::in_force(m);
}

}  // namespace sunder::shell
