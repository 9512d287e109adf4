#include "shell/mechanics/gathered_point.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "shell/mechanics/gathered_ductile.h"

namespace sunder::shell {
namespace {

Forms<double> forms_of(const GatheredPoint& p, const Derivatives<double>& d) {
  Forms<double> f = surface_forms(d);
  if (p.kind == PointKind::kLinear) f.b = p.metric.b;  // no bending: the curvature is that of the rest state
  return f;
}

}  // namespace

std::uint64_t fresh_stamp() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

std::vector<GatheredFunction> patch_functions(const Patch& patch, const Vec2& p, int stride) {
  std::vector<GatheredFunction> out;
  patch_functions(patch, p, stride, out);
  return out;
}

void patch_functions(const Patch& patch, const Vec2& p, int stride, std::vector<GatheredFunction>& out) {
  const ShapeFunctions n = patch.shape_functions(p);
  out.clear();
  for (int k = 0; k < n.count(); ++k)
    out.push_back({n.row(k) * stride + n.column(k), {n.value[k], n.u[k], n.v[k], n.uu[k], n.vv[k], n.uv[k]}});
}

Derivatives<double> gather(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x) {
  // u v uu vv as a pack, uv beside it: each sum has the order of the functions
  Pack4 four[3] = {};
  double uv[3] = {};
  for (const GatheredFunction& f : p.functions) {
    const Pack4 n = load<Pack4>(&f.n[1]);
    for (int c = 0; c < 3; ++c) {
      const double at = x[static_cast<std::size_t>(c) * t.component_stride + f.slot];
      four[c] += n * at, uv[c] += f.n[5] * at;
    }
  }
  const auto vector = [&](int k) { return Vector<double>{four[0][k], four[1][k], four[2][k]}; };
  return {vector(0), vector(1), vector(2), vector(3), {uv[0], uv[1], uv[2]}};
}

namespace {

template <bool kHeals>
typename WeakeningLayers<kHeals>::template At<double> weakening_at(const RowTables& t, PointDamage& d,
                                                                   double brittleness) {
  typename WeakeningLayers<kHeals>::template At<double> law(t, brittleness);
  law.points[0] = &d, law.strength = d.strength, law.any_watched = true;
  return law;
}

// Calls f(law) with the law in force at a point.
template <class F>
double with_weakening_at(const RowTables& t, const PointMemory& memory, F&& f) {
  PointDamage own = *memory.damage;
  return memory.heals ? f(weakening_at<true>(t, own, memory.brittleness))
                      : f(weakening_at<false>(t, own, memory.brittleness));
}
template <class F>
double with_law_at(const RowTables& t, const GatheredPoint& p, const PointMemory& memory, F&& f) {
  if (memory.plastic) return f(YieldingLayers::At<OnePlace>({t, p.block, p.lane}, *memory.plastic));
  if (!memory.damage) return f(ElasticLayers::At<OnePlace>{t});
  return with_weakening_at(t, memory, f);
}

// Energy of the full material [J], and what weakening removes. Out of line, so that the product is rounded by itself.
[[gnu::noinline]] double weakened_energy(const RowTables& t, const GatheredPoint& p, const Forms<double>& f,
                                         const PointMemory& memory, Loss& loss) {
  return with_weakening_at(t, memory, [&](auto law) {
    const Resultants<double> r = law.template resultants<true, false>(f, p.metric, true);
    loss = loss_of(f, law.lost, 0);
    return p.area * r.energy;
  });
}

}  // namespace

std::optional<Derivatives<double>> point_force(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x,
                                               double times, const PointMemory& memory) {
  if (p.kind == PointKind::kDead) return {};
  const Derivatives<double> d = gather(t, p, x);
  const Forms<double> f = forms_of(p, d);
  if (!bears(f, p.metric, t.layers)) return {};
  Resultants<double> r;
  if (memory.damage && memory.plastic)
    r = ductile_resultants(t, p, f, memory);
  else
    with_law_at(t, p, memory, [&](auto law) {
      r = law.template resultants<false, false>(f, p.metric, true);
      return 0.0;
    });
  if (!std::isfinite(r.n.c11 + r.n.c22 + r.m.c11 + r.m.c22)) return {};
  if (p.kind == PointKind::kLinear) r.m = {0.0, 0.0, 0.0};
  return section_forces(d, f, r, times * p.area);
}

double point_energy(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x,
                    const PointMemory& memory) {
  if (p.kind == PointKind::kDead) return 0.0;
  const Forms<double> f = forms_of(p, gather(t, p, x));
  if (!bears(f, p.metric, t.layers)) return 0.0;
  double energy = 0.0;
  if (memory.damage && memory.plastic) {
    double retained;
    energy = ductile_energy(t, p, f, memory, retained);
    energy -= retained;
  } else if (memory.plastic) {
    YieldingLayers::At<OnePlace> law({t, p.block, p.lane}, *memory.plastic);
    energy = p.area * law.integrate<true, false, false>(f, p.metric, true).energy;
  } else if (memory.damage) {
    Loss loss;
    energy = weakened_energy(t, p, f, memory, loss);
    energy -= memory.damage->retained + retained_since(*memory.damage, loss, p.area);
  } else {
    energy = p.area * ElasticLayers::At<OnePlace>{t}.resultants<true, false>(f, p.metric, true).energy;
  }
  return std::isfinite(energy) ? energy : 0.0;
}

double full_energy(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x,
                   const PointMemory& memory) {
  if (!memory.damage || !memory.plastic) return point_energy(t, p, x, {nullptr, 0.0, true, memory.plastic});
  if (p.kind == PointKind::kDead) return 0.0;
  const Forms<double> f = forms_of(p, gather(t, p, x));
  if (!bears(f, p.metric, t.layers)) return 0.0;
  double retained;
  const double energy = ductile_energy(t, p, f, memory, retained);
  return std::isfinite(energy) ? energy : 0.0;
}

void settle_damage(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x, const PointMemory& memory,
                   PointDamage& d) {
  if (p.kind == PointKind::kDead) return;
  const Forms<double> f = forms_of(p, gather(t, p, x));
  if (!bears(f, p.metric, t.layers)) return;
  if (memory.plastic) return settle_ductile_damage(t, p, f, memory, d);
  Loss loss;
  weakened_energy(t, p, f, {&d, memory.brittleness, false, nullptr}, loss);
  keep_worst(d, loss, p.area);
}

namespace {

// Gives all layers of a point the mean state.
void average_states(const OnePlace& place, std::vector<double>& states) {
  const Layers& layers = place.t.layers;
  const int count = static_cast<int>(layers.zeta.size());
  const double thickness = thickness_of(layers);
  for (int field = 0; field < 4; ++field) {
    double mean = 0.0;
    for (int l = 0; l < count; ++l) mean += layers.weight[l] / thickness * place.load(states, 4 * count, 4 * l + field);
    for (int l = 0; l < count; ++l) place.store(states, 4 * count, 4 * l + field, true, mean);
  }
}

}  // namespace

double settle_flow(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x,
                   const PointMemory& memory) {
  if (p.kind == PointKind::kDead) return 0.0;
  const Forms<double> f = forms_of(p, gather(t, p, x));
  const OnePlace place{t, p.block, p.lane};
  if (!bears(f, p.metric, t.layers)) {
    place.store(*memory.plastic->forms, kFormFields, 0, true, -1.0);
    return 0.0;
  }
  if (p.kind == PointKind::kLinear && memory.plastic->has_states()) average_states(place, *memory.plastic->states);
  if (memory.damage) return settle_ductile_flow(t, p, f, memory);
  RowPlasticity advancing = *memory.plastic;
  advancing.advance = true;
  YieldingLayers::At<OnePlace> law{place, advancing};
  law.integrate<false, false, true>(f, p.metric, true);
  double work = 0.0;
  law.keep<false, false>(f, true, true, p.area, work);
  return work;
}

namespace {

// The change of the reference metric by the flow of a layer.
Sym2<double> flow_of(const OnePlace& place, const std::vector<double>& states, std::size_t layer) {
  const int fields = 4 * static_cast<int>(place.t.layers.zeta.size()), first = 4 * static_cast<int>(layer);
  return {place.load(states, fields, first), place.load(states, fields, first + 1),
          place.load(states, fields, first + 2)};
}

// Resultants of the full stress, with the stored states of layers that yield.
Resultants<double> full_resultants(const RowTables& t, const GatheredPoint& p, const Forms<double>& f,
                                   const std::vector<double>& plastic) {
  Resultants<double> r{};
  for (std::size_t l = 0; l < t.layers.zeta.size(); ++l) {
    const double z = t.layers.zeta[l], w = t.layers.weight[l];
    const Sym2<double> a = reference_at(p.metric, t.layers, l), flow = flow_of({t, p.block, p.lane}, plastic, l);
    const Sym2<double> s = plane_stress<double>(at_height(f.a, f.b, z),
                                                {a.c11 + flow.c11, a.c22 + flow.c22, a.c12 + flow.c12}, t.elasticity)
                               .s;
    r.n = {r.n.c11 + w * s.c11, r.n.c22 + w * s.c22, r.n.c12 + w * s.c12};
    r.m = {r.m.c11 + w * z * s.c11, r.m.c22 + w * z * s.c22, r.m.c12 + w * z * s.c12};
  }
  return r;
}

}  // namespace

std::array<double, 6> undamaged_stress(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x,
                                       const std::vector<double>* plastic) {
  if (p.kind == PointKind::kDead) return {};
  const Forms<double> f = forms_of(p, gather(t, p, x));
  if (!bears(f, p.metric, t.layers)) return {};
  const Resultants<double> r = plastic ? full_resultants(t, p, f, *plastic)
                                       : integrate_layers<double, false>(f, p.metric, t.layers, t.elasticity);
  const double n[3] = {r.n.c11, r.n.c22, r.n.c12}, none[3] = {};
  const double m[3] = {r.m.c11, r.m.c22, r.m.c12};
  return linear_stress(n, p.kind == PointKind::kLinear ? none : m, section_faces(t.layers));
}

double largest_stretch(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x,
                       const std::vector<double>* plastic) {
  const Derivatives<double> d = gather(t, p, x);
  const Sym2<double> c{dot(d.u, d.u), dot(d.v, d.v), dot(d.u, d.v)};
  Sym2<double> a = p.metric.a;
  for (std::size_t l = 0; plastic && l < t.layers.zeta.size(); ++l) {
    const double share = t.layers.weight[l] / thickness_of(t.layers);
    const Sym2<double> flow = flow_of({t, p.block, p.lane}, *plastic, l);
    a = {a.c11 + share * flow.c11, a.c22 + share * flow.c22, a.c12 + share * flow.c12};
  }
  const double inverse = 1.0 / determinant(a);
  // squares of the stretches are the eigenvalues of a^-1 c
  const double half = 0.5 * inverse * (a.c22 * c.c11 + a.c11 * c.c22 - 2.0 * a.c12 * c.c12);
  return std::sqrt(half + std::sqrt(std::max(0.0, half * half - inverse * determinant(c))));
}

void spread(const RowTables& t, const GatheredPoint& p, const Derivatives<double>& g, int k,
            std::vector<double>& force) {
  const auto along = [&](const Vector<double>& v) { return k == 0 ? v.x : k == 1 ? v.y : v.z; };
  const double all[5] = {along(g.u), along(g.v), along(g.uu), along(g.vv), along(g.uv)};
  double* const component = force.data() + static_cast<std::size_t>(k) * t.component_stride;
  for (const GatheredFunction& f : p.functions)
    for (int i = 0; i < 5; ++i) component[f.slot] += f.n[i + 1] * all[i];
}

}  // namespace sunder::shell
