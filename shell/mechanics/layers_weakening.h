#pragma once
// Layers that weaken: Rankine damage (paper 5.1, eq. 9). The largest principal Cauchy stress sets the damage, which
// weakens tension and leaves compression. Damage follows the present stress and heals, or stays at its maximum.
#include <algorithm>
#include <array>
#include <vector>

#include "shell/mechanics/layers_elastic.h"

namespace sunder::shell {

/// Brittleness H = Hbar l / (1 - Hbar l) of eq. 9, Hbar = strength^2 / (2 E G_f) [1/m], with the width l [m] of the
/// damaged zone. Returns -1 for Hbar l >= 1: the grid does not resolve the softening.
inline double brittleness(double strength, double youngs_modulus, double fracture_energy, double width) {
  const double product = strength * strength * width / (2.0 * youngs_modulus * fracture_energy);
  return product < 1.0 ? product / (1.0 - product) : -1.0;
}

template <class T>
inline T largest(const T& a, const T& b) {
  return select(a > b, a, b);
}

/// Weakens S (second Piola-Kirchhoff, contravariant) at metric C and volume ratio J = J0 lambda3 in place. Returns the
/// damage, 0 to 1 by eq. 9; without healing it is at least `least`. The mixed Cauchy stress sigma = S C / J has
/// principal values s1 >= s2, and sigma' = sigma - c (s1+ P1 + s2+ P2). In two dimensions the positive part is a I + b
/// sigma, with b = (s1+ - s2+) / (s1 - s2) and a = s1+ - b s1. For s1 = s2 any b is right, since a follows it. Stresses
/// and strength here are multiplied by J, which leaves one division; divisions cost most.
template <class T, bool kHeals = true>
[[gnu::always_inline]] inline T weaken(Sym2<T>& s, const Sym2<T>& c, const T& volume, const T& strength, double h,
                                       const T& least = T{}) {
  constexpr double kApart = 1e-20;  // share of the strength; for a smaller difference the error of b does not matter
  const T none = splat<T>(0.0), limit = strength * volume;
  const T mean = 0.5 * (s.c11 * c.c11 + s.c22 * c.c22) + s.c12 * c.c12;
  const T det_c = determinant(c);
  const T radius = square_root(largest<T>(mean * mean - determinant(s) * det_c, none));
  const T high = mean + radius, low = mean - radius;
  const T over = largest<T>(high, limit), apart = largest<T>(2.0 * radius, kApart * limit);
  const T inverse = 1.0 / (over * apart * det_c);
  const T full = (1.0 + h) * ((over - limit) * (inverse * apart * det_c));  // exactly zero without damage
  T damage = select(full < 1.0, full, splat<T>(1.0));
  if constexpr (!kHeals) damage = largest<T>(damage, least);
  const T tension = largest<T>(high, none);
  const T b = (tension - largest<T>(low, none)) * (inverse * over * det_c), a = tension - b * high;
  const T keep = 1.0 - damage * b;
  const T metric = damage * a * (inverse * over * apart);  // times the adjugate of C it is damage a J C^-1
  s = {keep * s.c11 - metric * c.c22, keep * s.c22 - metric * c.c11, keep * s.c12 + metric * c.c12};
  return damage;
}

/// Damage of the layers of a Gauss point.
struct PointDamage {
  double strength = 0.0;                            // [Pa]
  std::array<float, kMostLayers> now{}, history{};  // damage and its maximum over time, of each layer
  std::array<double, 6> forms{}, lost{};            // of the last substep, as in Loss
  // With healing: energy that the weakened stress did not store [J]. Without: energy that the removed stress would
  // store [J].
  double retained = 0.0;
  bool fresh = true;  // `forms` belong to other shape functions
  float damage() const { return *std::max_element(now.begin(), now.end()); }
  float worst() const { return *std::max_element(history.begin(), history.end()); }
};

/// State of a point for its energy book: the forms a 11 22 12 and b 11 22 12, and the resultants n and m of the removed
/// stress.
struct Loss {
  std::array<double, 6> forms, lost;
  double energy = 0.0;  // energy that the removed stress would store [J/m^2]; only without healing
};

/// Work of the removed stress from the last substep to this state [J], by the trapezoidal rule.
double retained_since(const PointDamage& d, const Loss& now, double area);
/// Takes over the new state. Returns the retained energy [J] of a point that has healed, else 0.
double keep(PointDamage& d, const Loss& now, double area);
/// The same without healing. A point stores the full energy less the energy that the removed stress would store; other
/// retained energy is dissipated. Returns the dissipated energy [J].
double keep_worst(PointDamage& d, const Loss& now, double area);

/// Resultants of weakened layers. `damage` gets the damage of each layer; without healing it holds the least damage on
/// entry. With `kLost`, `lost` gets the resultants n and m of the removed stress. Without healing `lost` also gets an
/// energy: the full one times the share of S : E that was removed. In tension along one or both axes that is c psi, and
/// at fixed c all is elastic. With compression along one axis a cycle leaves an error up to the order of Poisson's
/// ratio times it, of either sign.
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
      const Sym2<T> removed{full.c11 - p.s.c11, full.c22 - p.s.c22, full.c12 - p.s.c12};
      lost.n.c11 += w * removed.c11, lost.n.c22 += w * removed.c22, lost.n.c12 += w * removed.c12;
      lost.m.c11 += (w * z) * removed.c11, lost.m.c22 += (w * z) * removed.c22, lost.m.c12 += (w * z) * removed.c12;
      if constexpr (!kHeals) {
        const auto work = [&](const Sym2<T>& s) {
          return s.c11 * (c.c11 - a.c11) + s.c22 * (c.c22 - a.c22) + 2.0 * s.c12 * (c.c12 - a.c12);
        };
        const T share = largest<T>(work(removed) / largest<T>(work(full), splat<T>(1e-300)), T{});
        // near rest round-off may exceed 1
        lost.energy += w * energy * select(share < 1.0, share, splat<T>(1.0));
      }
    }
  }
  return r;
}

template <class T>
inline Loss loss_of(const Forms<T>& f, const Resultants<T>& lost, int lane) {
  const auto at = [lane](const T& v) { return lane_of(v, lane); };
  return {{at(f.a.c11), at(f.a.c22), at(f.a.c12), at(f.b.c11), at(f.b.c22), at(f.b.c12)},
          {at(lost.n.c11), at(lost.n.c22), at(lost.n.c12), at(lost.m.c11), at(lost.m.c22), at(lost.m.c12)},
          at(lost.energy)};
}

/// Memory of points in rows that damage may weaken: no crack has touched them. It changes where stress is recorded.
struct RowDamage {
  const std::vector<char>* watched = nullptr;     // [block][lane]; null: no damage
  const std::vector<double>* strength = nullptr;  // [block][lane] [Pa]
  const std::vector<int>* point_of = nullptr;     // [block][lane]: index into `points`
  std::vector<PointDamage>* points = nullptr;
  double brittleness = 0.0;               // H of eq. 9
  bool heals = true;                      // false: the damage of a layer is its maximum over time
  double healed = 0.0, dissipated = 0.0;  // out, as in DamageLaw [J]
};

/// Memory of gathered points that damage may weaken.
struct DamageLaw {
  std::vector<PointDamage>* points = nullptr;  // parallel to the gathered points; null: no damage
  double brittleness = 0.0;                    // H of eq. 9
  bool heals = true;                           // false: the damage of a layer is its maximum over time
  // out, with healing: retained energy of points that healed in this substep [J]. In one dimension it is zero. A cycle
  // of biaxial stress leaves up to the order of the fracture energy, of either sign.
  double healed = 0.0;
  double dissipated = 0.0;  // out, without healing: energy that damage dissipated in this substep [J]
};

/// The law of layers that weaken, for both kernels. Without healing the damage of a layer is its maximum over time.
template <bool kHeals>
struct WeakeningLayers {
  static constexpr bool kRemembers = true, kFolds = false, kAdvances = false;
  static bool in_force(const LayerMemory& m) {
    const bool rows = m.row_damage && m.row_damage->watched;
    return (rows && m.row_damage->heals == kHeals) || (m.point_damage && m.point_damage->heals == kHeals);
  }

  template <class T>
  struct At {
    static constexpr int kCount = lanes<T>();
    const RowTables& t;
    double brittleness;
    std::array<PointDamage*, kCount> points{};  // null: the lane is not watched
    T strength{};                               // [Pa]
    bool any_watched = false;
    T damage[kMostLayers];
    Resultants<T> lost;
    At(const RowTables& tables, double h) : t(tables), brittleness(h) {}  // leaves the arrays as they are

    template <bool kEnergy, bool kRecord, class Mask>
    Resultants<T> resultants(const Forms<T>& f, const ReferenceMetric<T>& ref, const Mask&) {
      if (!any_watched) return integrate_layers<T, kEnergy>(f, ref, t.layers, t.elasticity);
      if constexpr (!kHeals)
        for (int i = 0; i < kCount; ++i)
          for (std::size_t l = 0; l < t.layers.zeta.size(); ++l)
            set_lane(damage[l], i, points[i] ? points[i]->history[l] : 0.0);
      constexpr bool kLost = kEnergy || kRecord;
      return integrate_weakened_layers<T, kEnergy, kLost, kHeals>(f, ref, t.layers, t.elasticity, strength, brittleness,
                                                                  damage, lost);
    }

    const T* unbooked() const { return nullptr; }

    /// False for watched lanes that do not bear.
    auto sound(const Forms<T>& f, const ReferenceMetric<T>& ref) const {
      auto good = T{} > -1.0;
      if (!any_watched) return good;
      const auto bearing = bears(f, ref, t.layers);
      for (int i = 0; i < kCount; ++i)
        if (points[i] && !lane_of(bearing, i)) set_lane(good, i, false);
      return good;
    }

    /// Takes over the new state of watched lanes of `own`; those that are not `sound` start afresh. With kRecord the
    /// damage is written, and `booked` gains the energy that healed or was dissipated [J]. With kEnergy returns the
    /// energy that the point does not store [J].
    template <bool kEnergy, bool kRecord, class Mask>
    T keep(const Forms<T>& f, const Mask& own, const Mask& sound, const T& area, double& booked) {
      T retained{};
      if (!any_watched) return retained;
      for (int i = 0; i < kCount; ++i) {
        if (!points[i] || !lane_of(own, i)) continue;
        PointDamage& d = *points[i];
        if (!lane_of(sound, i)) {
          d.fresh = true;
          continue;
        }
        const Loss loss = loss_of(f, lost, i);
        const double a = lane_of(area, i);
        if constexpr (kEnergy && kHeals) set_lane(retained, i, d.retained + retained_since(d, loss, a));
        if constexpr (kRecord) {
          for (std::size_t l = 0; l < t.layers.zeta.size(); ++l) {
            d.now[l] = static_cast<float>(lane_of(damage[l], i));
            d.history[l] = std::max(d.history[l], d.now[l]);
          }
          booked += (kHeals ? shell::keep : keep_worst)(d, loss, a);
        }
        // energy that is not booked yet counts as stored
        if constexpr (kEnergy && !kHeals) set_lane(retained, i, d.retained + retained_since(d, loss, a));
      }
      return retained;
    }
  };

  static At<Pack> at(const RowPlaces& p, const LayerMemory& m) {
    constexpr double kNever = 1e300;  // [Pa], strength of a lane that is not watched
    const RowDamage& law = *m.row_damage;
    At<Pack> at(p.t, law.brittleness);
    const std::size_t first = p.t.at(p.block, 1, 0, p.lane);
    std::array<char, kLanes> watched;
    std::copy_n(law.watched->data() + first, kLanes, watched.data());
    at.any_watched = watched != std::array<char, kLanes>{};
    if (!at.any_watched) return at;
    at.strength = load<Pack>(law.strength->data() + first);
    for (int i = 0; i < kLanes; ++i)
      if (watched[i])
        at.points[i] = &(*law.points)[(*law.point_of)[first + i]];
      else
        at.strength[i] = kNever;
    return at;
  }
  static At<Pack> at(const PointPlaces& p, const LayerMemory& m) {
    const DamageLaw& law = *m.point_damage;
    At<Pack> at(p.t, law.brittleness);
    at.any_watched = true;
    for (int i = 0; i < kLanes; ++i) {
      at.points[i] = &(*law.points)[p.index[i]];
      at.strength[i] = at.points[i]->strength;
    }
    return at;
  }
  static void book_rows(const LayerMemory& m, double booked) {
    (kHeals ? m.row_damage->healed : m.row_damage->dissipated) += booked;
  }
  static void book_points(const LayerMemory& m, double booked) {
    (kHeals ? m.point_damage->healed : m.point_damage->dissipated) += booked;
  }
};

}  // namespace sunder::shell
