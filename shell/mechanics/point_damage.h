#pragma once
// What a damaged Gauss point remembers, wherever it is summed.
#include <algorithm>
#include <array>

#include "shell/mechanics/damage.h"
#include "shell/mechanics/section.h"

namespace sunder::shell {

/// Rankine damage of a Gauss point, layer by layer.
constexpr int kMostLayers = 16;
struct PointDamage {
  double strength = 0.0;                            // [Pa]
  std::array<float, kMostLayers> now{}, history{};  // damage and its maximum over time, of each layer
  std::array<double, 6> forms{}, lost{};            // of the last substep: a, b and what weakening took of n, m
  double retained = 0.0;                            // energy that the weakened stress did not store [J]; without
                                                    // healing: that it would give back if it were not weakened
  bool fresh = true;                                // `forms` is not of these shape functions
  float damage() const { return *std::max_element(now.begin(), now.end()); }
  float worst() const { return *std::max_element(history.begin(), history.end()); }
};

/// The forms a 11 22 12, then b, and what weakening took of the resultants n, then m, at them.
struct Loss {
  std::array<double, 6> forms, lost;
  double energy = 0.0;  // what the stress taken would store [J/m^2]; only without healing
};

/// What weakening spares between the last substep and this state, by the trapezoidal rule [J].
double retained_since(const PointDamage& d, const Loss& now, double area);
/// Keeps what the next substep needs. Returns what was spared and not given back where the point has healed.
double keep(PointDamage& d, const Loss& now, double area);
/// The same without healing: a point stores the full energy less what the stress taken would store; what else was
/// spared is dissipated. Returns that [J].
double keep_worst(PointDamage& d, const Loss& now, double area);

/// Resultants of weakened layers. `damage` gets that of each layer, `lost` what weakening took of n and m where
/// `kLost`. Without healing `damage` has the least of each layer when it comes in, and `lost` also the energy: the full
/// one times the share of S : E that was taken. In tension along one or both axes that is c psi, and all at fixed c is
/// elastic; where one axis is pressed, a cycle leaves up to the order of Poisson's ratio of it, of either sign.
template <class T, bool kEnergy, bool kLost, bool kHeals = true>
inline Resultants<T> integrate_weakened_layers(const Forms<T>& f, const ReferenceMetric<T>& ref, const Layers& layers,
                                               const Elasticity& e, const T& strength, double brittleness, T* damage,
                                               Resultants<T>& lost) {
  Resultants<T> r{{T{}, T{}, T{}}, {T{}, T{}, T{}}, T{}};
  if constexpr (kLost) lost = r;
  for (std::size_t l = 0; l < layers.zeta.size(); ++l) {
    const double z = layers.zeta[l], w = layers.weight[l];
    const Sym2<T> c = at_height(f.a, f.b, z);
    const Sym2<T> a = reference_at(ref, layers, l);
    PlaneStress<T> p = plane_stress<T>(c, a, e);
    T energy;
    if constexpr (kEnergy || (kLost && !kHeals)) energy = plane_stress_energy<T>(p, c, a, e);
    if constexpr (kEnergy) r.energy += w * energy;
    const Sym2<T> full = p.s;
    if constexpr (kHeals)
      damage[l] = weaken<T>(p.s, c, volume_ratio<T>(p, e), strength, brittleness);
    else
      damage[l] = weaken<T, false>(p.s, c, volume_ratio<T>(p, e), strength, brittleness, damage[l]);
    r.n.c11 += w * p.s.c11, r.n.c22 += w * p.s.c22, r.n.c12 += w * p.s.c12;
    r.m.c11 += (w * z) * p.s.c11, r.m.c22 += (w * z) * p.s.c22, r.m.c12 += (w * z) * p.s.c12;
    if constexpr (kLost) {
      const Sym2<T> gone{full.c11 - p.s.c11, full.c22 - p.s.c22, full.c12 - p.s.c12};
      lost.n.c11 += w * gone.c11, lost.n.c22 += w * gone.c22, lost.n.c12 += w * gone.c12;
      lost.m.c11 += (w * z) * gone.c11, lost.m.c22 += (w * z) * gone.c22, lost.m.c12 += (w * z) * gone.c12;
      if constexpr (!kHeals) {
        const auto work = [&](const Sym2<T>& s) {
          return s.c11 * (c.c11 - a.c11) + s.c22 * (c.c22 - a.c22) + 2.0 * s.c12 * (c.c12 - a.c12);
        };
        const T share = largest<T>(work(gone) / largest<T>(work(full), splat<T>(1e-300)), T{});
        lost.energy += w * energy * select(share < 1.0, share, splat<T>(1.0));  // beyond is round-off near rest
      }
    }
  }
  return r;
}

/// One lane of a pack, or a scalar, as `retained_since` and `keep` ask for it.
inline double lane_of(double v, int) { return v; }
template <class P>
requires kIsPack<P>
inline double lane_of(const P& v, int lane) { return v[lane]; }
template <class T>
inline Loss loss_of(const Forms<T>& f, const Resultants<T>& lost, int lane) {
  const auto at = [lane](const T& v) { return lane_of(v, lane); };
  return {{at(f.a.c11), at(f.a.c22), at(f.a.c12), at(f.b.c11), at(f.b.c22), at(f.b.c12)},
          {at(lost.n.c11), at(lost.n.c22), at(lost.n.c12), at(lost.m.c11), at(lost.m.c22), at(lost.m.c12)},
          at(lost.energy)};
}

}  // namespace sunder::shell
