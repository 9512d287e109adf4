#include "shell/mechanics/gathered_ductile.h"

#include "shell/mechanics/layers_ductile.h"

namespace sunder::shell {
namespace {

// Calls f(law) with the law of a point and a copy of its damage.
template <bool kHeals, class F>
auto with_law_of(const RowTables& t, const GatheredPoint& p, const PointMemory& memory, F&& f) {
  PointDamage own = *memory.damage;
  typename WeakeningLayers<kHeals>::template At<double> weak(t, memory.brittleness);
  weak.points[0] = &own, weak.strength = own.strength, weak.any_watched = true;
  return f(typename DuctileLayers<kHeals>::template At<OnePlace>({t, p.block, p.lane}, *memory.plastic, weak));
}
template <class F>
auto with_ductile_law(const RowTables& t, const GatheredPoint& p, const PointMemory& memory, F&& f) {
  return memory.heals ? with_law_of<true>(t, p, memory, f) : with_law_of<false>(t, p, memory, f);
}

// Energy of the full material [J], what weakening removes, and the plastic work that it would have done [J].
struct FullState {
  double energy;
  Loss loss;
  double lost_flow;
};
FullState full_state(const RowTables& t, const GatheredPoint& p, const Forms<double>& f, const PointMemory& memory) {
  return with_ductile_law(t, p, memory, [&](auto law) {
    const double energy = law.template resultants<true, false>(f, p.metric, true).energy;
    return FullState{p.area * energy, loss_of(f, law.weak.lost, 0), p.area * law.lost_flow};
  });
}

}  // namespace

Resultants<double> ductile_resultants(const RowTables& t, const GatheredPoint& p, const Forms<double>& f,
                                      const PointMemory& memory) {
  return with_ductile_law(t, p, memory,
                          [&](auto law) { return law.template resultants<false, false>(f, p.metric, true); });
}

double ductile_energy(const RowTables& t, const GatheredPoint& p, const Forms<double>& f, const PointMemory& memory,
                      double& retained) {
  const FullState s = full_state(t, p, f, memory);
  const PointDamage& d = *memory.damage;
  retained = d.retained + retained_since(d, s.loss, p.area) - (d.fresh ? 0.0 : s.lost_flow);
  return s.energy;
}

void settle_ductile_damage(const RowTables& t, const GatheredPoint& p, const Forms<double>& f,
                           const PointMemory& memory, PointDamage& d) {
  PointMemory own = memory;
  own.damage = &d, own.heals = false;
  const FullState s = full_state(t, p, f, own);
  if (!d.fresh) d.retained -= s.lost_flow;
  keep_worst(d, s.loss, p.area);
}

double settle_ductile_flow(const RowTables& t, const GatheredPoint& p, const Forms<double>& f,
                           const PointMemory& memory) {
  RowPlasticity advancing = *memory.plastic;
  advancing.advance = true;
  PointMemory own = memory;
  own.plastic = &advancing;
  return with_ductile_law(t, p, own, [&](auto law) {
    double work = 0.0;
    law.template integrate<false, false, true>(f, p.metric, true);
    law.flow.template keep<false, false>(f, true, true, p.area, work);
    return work;
  });
}

}  // namespace sunder::shell
