#include "shell/mechanics/layers_ductile.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sunder::shell {
namespace {

constexpr int kStops = 32;          // at the strength, on the way to the trial strain
constexpr int kFlowSteps = 60;      // of Newton, until the weakened stress is at the yield stress
constexpr int kScales = 8;          // passes until the scale of the strength is that of the result
constexpr int kHalvings = 40;       // of the way on which the strength is reached
constexpr double kAtYield = 1e-9;   // share of the yield stress
constexpr double kSteep = 0.05;     // share of the slope of the full stress, above which steps are Newton's
constexpr double kShortest = 0.02;  // share of the yield stress that other steps take off at least

// An elastic strain in orthonormal axes: its mean, half the difference of 11 and 22, and 12.
struct PlaneStrain {
  double mean = 0.0, half = 0.0, shear = 0.0;

  double radius() const { return std::hypot(half, shear); }
  PlaneStrain plus(const PlaneStrain& d, double by) const {
    return {mean + by * d.mean, half + by * d.half, shear + by * d.shear};
  }
};

PlaneStrain in_axes(const PlaneBasis& axes, const Sym2<double>& covariant) {
  const Sym2<double> e = axes.pull(covariant);
  return {0.5 * (e.c11 + e.c22), 0.5 * (e.c11 - e.c22), e.c12};
}

PlaneStrain elastic_strain(const PlaneBasis& axes, const Sym2<double>& c, const Sym2<double>& a) {
  return in_axes(axes, {0.5 * (c.c11 - a.c11), 0.5 * (c.c22 - a.c22), 0.5 * (c.c12 - a.c12)});
}

// A layer on its way to the trial strain.
struct DuctileLayer {
  double bulk, two_mu;  // [Pa]: mean and radius of the stress are these times those of the elastic strain
  double yield, hardening;
  Weakness w;
  PlaneStrain elastic, flowed{};
  double strain;  // equivalent plastic strain

  double high(const PlaneStrain& e) const { return bulk * e.mean + two_mu * e.radius(); }

  // Stress at which damage grows [Pa].
  double onset() const {
    return w.least < 1.0 ? w.strength / (1.0 - w.least / (1.0 + w.brittleness))
                         : std::numeric_limits<double>::infinity();
  }

  // Weakened principal stresses [Pa].
  struct Stress {
    double first, second;
    double by_first, second_by_first, by_second;  // derivatives by the full ones
    double mean() const { return 0.5 * (first + second); }
    double half() const { return 0.5 * (first - second); }
    double mises() const { return std::sqrt(mean() * mean() + 3.0 * half() * half()); }
  };
  Stress stress() const {
    const double s1 = high(elastic), s2 = s1 - 2.0 * two_mu * elastic.radius();
    if (s1 <= 0.0) return {s1, s2, 1.0, 0.0, 1.0};
    const double now = s1 > w.strength ? std::min(1.0, (1.0 + w.brittleness) * (1.0 - w.strength / s1)) : 0.0;
    const double c = std::max(now, w.least), keep = 1.0 - c;
    const bool grows = now > w.least && now < 1.0;
    const double rise = grows ? (1.0 + w.brittleness) * w.strength / s1 : 0.0;  // s1 dc/ds1
    if (s2 <= 0.0) return {keep * s1, s2, keep - rise, 0.0, 1.0};
    return {keep * s1, keep * s2, keep - rise, -rise * s2 / s1, keep};
  }

  // Flows until the weakened stress is at the yield stress. Returns whether there was any flow.
  bool flow() {
    const double fastest = 0.5 / two_mu;  // a step that cannot turn the axes over
    bool any = false;
    for (int i = 0; i < kFlowSteps; ++i) {
      const Stress s = stress();
      const double mean = s.mean(), half = s.half(), mises = s.mises(), limit = yield + hardening * strain;
      const double over = mises - limit;
      if (over <= kAtYield * yield) break;
      const double harder = hardening * (2.0 / 3.0) * mises;
      const double of_first = bulk * mean / 3.0 + two_mu * half, of_second = bulk * mean / 3.0 - two_mu * half;
      const double fall = ((2.0 * s.first - s.second) * s.by_first * of_first +
                           (2.0 * s.second - s.first) * (s.second_by_first * of_first + s.by_second * of_second)) /
                              (2.0 * mises) +
                          harder;
      // Beyond the strength the weakened stress rises as the full one falls: the layer flows on until it has passed
      // the strength. Steps are then by the slope of the full stress.
      const double full = (bulk * mean * mean / 3.0 + 3.0 * two_mu * half * half) / mises + harder;
      const double gamma =
          std::min(fall > kSteep * full ? over / fall : std::max(over, kShortest * limit) / full, fastest);
      const double radius = elastic.radius(), of_radius = radius > 0.0 ? gamma * half / radius : 0.0;
      const PlaneStrain step{gamma * mean / 3.0, of_radius * elastic.half, of_radius * elastic.shear};
      elastic = elastic.plus(step, -1.0), flowed = flowed.plus(step, 1.0);
      strain += gamma * (2.0 / 3.0) * mises;
      any = true;
    }
    return any;
  }

  // Goes to the strain `step` further on.
  void go(const PlaneStrain& step) {
    const double most = onset();
    double left = 1.0;
    bool flowed_here = true;
    for (int k = 0; k < kStops && left > 0.0; ++k) {
      double part = left;
      // beyond the strength a layer bears less: what it must flow before that is found there
      if (flowed_here && high(elastic) < most && high(elastic.plus(step, left)) > most) {
        double below = 0.0, above = left;
        for (int i = 0; i < kHalvings; ++i) {
          const double middle = 0.5 * (below + above);
          (high(elastic.plus(step, middle)) < most ? below : above) = middle;
        }
        part = below;
      }
      if (k + 1 == kStops) part = left;
      elastic = elastic.plus(step, part), left -= part;
      flowed_here = flow();
    }
  }
};

// Larger principal stress of Hooke's law over that of the elastic law, at plastic metric `a`. Damage follows the
// latter.
double hooke_share(const PlaneBasis& axes, const Sym2<double>& c, const Sym2<double>& a, const Elasticity& e,
                   const DuctileLayer& layer) {
  const PlaneStress<double> p = plane_stress<double>(c, a, e);
  const Sym2<double> s = axes.push(p.s, 1.0 / volume_ratio<double>(p, e));
  const double high = 0.5 * (s.c11 + s.c22) + std::hypot(0.5 * (s.c11 - s.c22), s.c12);
  const double hooke = layer.high(elastic_strain(axes, c, a));
  return high > 0.0 && hooke > 0.0 ? hooke / high : 1.0;
}

}  // namespace

std::optional<PlasticState<double>> flow_while_weakened(const PlasticState<double>& old, const Sym2<double>& c,
                                                        const Sym2<double>& a, const Sym2<double>& before,
                                                        const Elasticity& e, const Yielding& y, const Weakness& w) {
  const PlaneBasis axes(c);
  const auto metric = [&](const Sym2<double>& change) {
    return Sym2<double>{a.c11 + change.c11, a.c22 + change.c22, a.c12 + change.c12};
  };
  const PlaneStrain trial = elastic_strain(axes, c, metric(old.change)), start = in_axes(axes, before);
  DuctileLayer layer{y.youngs_modulus / (1.0 - y.poisson_ratio),
                     y.youngs_modulus / (1.0 + y.poisson_ratio),
                     y.yield_stress,
                     y.hardening_modulus,
                     w,
                     start,
                     {},
                     old.strain};
  // The law of flow is Hooke's, so the strength is taken on its scale, which is that of the strain after the flow.
  double share = hooke_share(axes, c, metric(old.change), e, layer);
  if (layer.high(trial) <= share * w.strength && w.least == 0.0) return {};
  PlasticState<double> out = old;
  for (int k = 0; k < kScales; ++k) {
    layer.w.strength = share * w.strength;
    layer.elastic = start, layer.flowed = {}, layer.strain = old.strain;
    layer.go(trial.plus(start, -1.0));
    const PlaneStrain& f = layer.flowed;
    const Sym2<double> more = axes.lower({2.0 * (f.mean + f.half), 2.0 * (f.mean - f.half), 2.0 * f.shear});
    out = {{old.change.c11 + more.c11, old.change.c22 + more.c22, old.change.c12 + more.c12}, layer.strain};
    const double last = std::exchange(share, hooke_share(axes, c, metric(out.change), e, layer));
    if (std::abs(share - last) <= kAtYield) break;
  }
  return out;
}

}  // namespace sunder::shell
