#include "shell/mechanics/section_state.h"

#include <algorithm>
#include <cmath>

namespace sunder::shell {
namespace {

constexpr std::size_t kSmooth = 4, kRough = 2;  // layers that a polynomial passes through

// A layer's stress, and what it has done.
struct LayerState {
  double zeta = 0.0;                    // [m]
  Sym2<double> stress{};                // Cauchy, orthonormal [Pa]
  double plastic = 0.0, limit = 1e300;  // [-], yield stress [Pa]
};

void add(Sym2<double>& to, const Sym2<double>& a, double by = 1.0) {
  to = {to.c11 + by * a.c11, to.c22 + by * a.c22, to.c12 + by * a.c12};
}

// Stress at height `z` by the polynomial through the `count` layers nearest to it.
Sym2<double> stress_at(const std::vector<LayerState>& layers, double z, std::size_t count) {
  std::vector<const LayerState*> near;
  for (const LayerState& l : layers) near.push_back(&l);
  std::stable_sort(near.begin(), near.end(), [z](const auto* a, const auto* b) {
    return std::abs(a->zeta - z) < std::abs(b->zeta - z) - 1e-12 * (std::abs(a->zeta) + std::abs(b->zeta));
  });
  near.resize(std::min(near.size(), count));
  Sym2<double> sum{};
  for (const LayerState* a : near) {
    double weight = 1.0;
    for (const LayerState* b : near)
      if (a != b) weight *= (z - b->zeta) / (a->zeta - b->zeta);
    add(sum, a->stress, weight);
  }
  return sum;
}

// Layers of a section, and sums over them.
struct Section {
  std::vector<LayerState> layers;
  Sym2<double> n{}, m{};   // contravariant, for rest area
  double thickness = 0.0;  // now [m]
};

PlasticState<double> plastic_state(const OnePlace& place, const std::vector<double>& states, int layer, int count) {
  if (states.empty()) return {};
  const auto at = [&](int field) { return place.load(states, 4 * count, 4 * layer + field); };
  return {{at(0), at(1), at(2)}, at(3)};
}

Section sum_layers(const RowTables& t, const GatheredPoint& p, const Forms<double>& f, const SectionMemory& memory) {
  Section out;
  const int count = static_cast<int>(t.layers.zeta.size());
  for (int l = 0; l < count; ++l) {
    const double z = t.layers.zeta[l], w = t.layers.weight[l];
    const Sym2<double> c = at_height(f.a, f.b, z), rest = reference_at(p.metric, t.layers, l);
    Sym2<double> a = rest;
    LayerState layer{z};
    if (memory.plastic) {
      PlasticState<double> s = plastic_state({t, p.block, p.lane}, *memory.plastic, l, count);
      // beyond its peak a layer that weakens is above the yield stress, and does not flow
      if (!memory.damage) return_to_yield<double>(s, c, a, *memory.yielding);
      add(a, s.change);
      layer.plastic = s.strain;
      layer.limit = memory.yielding->yield_stress + memory.yielding->hardening_modulus * s.strain;
    }
    PlaneStress<double> stress = plane_stress<double>(c, a, t.elasticity);
    const double volume = volume_ratio<double>(stress, t.elasticity);
    if (const PointDamage* d = memory.damage) {
      if (memory.heals)
        weaken<double>(stress.s, c, volume, d->strength, memory.brittleness);
      else
        weaken<double, false>(stress.s, c, volume, d->strength, memory.brittleness, d->history[l]);
    }
    layer.stress = PlaneBasis(c).push(stress.s, 1.0 / volume);
    out.layers.push_back(layer);
    add(out.n, stress.s, w), add(out.m, stress.s, w * z);
    // plastic flow keeps the volume: the area that it makes is taken from the thickness
    out.thickness += w * std::sqrt(stress.stretch2 * determinant(rest) / determinant(a));
  }
  return out;
}

// A layer for each face, in place of the one in the middle, where bending has no layers.
void add_bending(const RowTables& t, const GatheredPoint& p, const Forms<double>& f, double thickness, double area,
                 Section& section) {
  Resultants<double> r{section.n, {}, 0.0};
  add_linear_bending<double, false>(r, f, p.metric, t.layers.bending, t.elasticity);
  section.m = r.m;
  const Sym2<double> bend = PlaneBasis(f.a).push(r.m, 6.0 / (thickness * thickness * area));
  const LayerState middle = section.layers.front();
  section.layers.assign(2, middle);
  for (const int side : {0, 1}) {
    section.layers[side].zeta = (side - 0.5) * thickness;
    add(section.layers[side].stress, bend, 2.0 * side - 1.0);
  }
}

Forms<double> forms_at(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x, Vec3& along) {
  const Derivatives<double> d = gather(t, p, x);
  Forms<double> f = surface_forms(d);
  if (p.kind == PointKind::kLinear) f.b = p.metric.b;  // no bending: the curvature is that of the rest state
  along = Vec3(d.u.x, d.u.y, d.u.z);
  return f;
}

}  // namespace

std::optional<SectionState> section_state(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x,
                                          double thickness, const SectionMemory& memory, const SectionCore* core) {
  if (p.kind == PointKind::kDead) return {};
  SectionState out;
  Vec3 along;
  const Forms<double> f = forms_at(t, p, x, along);
  if (!bears(f, p.metric, t.layers)) return {};
  Section section = sum_layers(t, p, f, memory);
  const double area = std::sqrt(determinant(f.a) / determinant(p.metric.a));
  if (t.layers.bending > 0.0) add_bending(t, p, f, thickness, area, section);
  if (p.kind == PointKind::kLinear) section.m = {};
  out.thickness = section.thickness;
  const double height[kSectionPlaces] = {0.5 * thickness, 0.0, -0.5 * thickness};
  const std::size_t count = memory.plastic || memory.damage ? kRough : kSmooth;
  // a polynomial must not pass from one ply of a laminate to the other
  const auto ply = [&](int k) {
    std::vector<LayerState> own = section.layers;
    if (core) std::erase_if(own, [&](const LayerState& l) { return l.zeta * height[k] < 0.0; });
    return own;
  };
  for (int k = 0; k < kSectionPlaces; ++k) {
    const std::vector<LayerState> layers = ply(k);
    const auto nearest = std::min_element(layers.begin(), layers.end(), [&](const LayerState& a, const LayerState& b) {
      return std::abs(a.zeta - height[k]) < std::abs(b.zeta - height[k]);
    });
    out.stress[k] = stress_at(layers, height[k], count);
    if (memory.plastic) out.stress[k] = within<double>(out.stress[k], nearest->limit);
    out.plastic[k] = nearest->plastic;
    const Sym2<double> c = at_height(f.a, f.b, height[k]), a = at_height(p.metric.a, p.metric.b, height[k]);
    out.strain[k] = PlaneBasis(a).pull({0.5 * (c.c11 - a.c11), 0.5 * (c.c22 - a.c22), 0.5 * (c.c12 - a.c12)});
  }
  if (core) {
    Vec3 unused;
    const Forms<double> of_core = forms_at(core->tables, core->point, x, unused);
    const Section inner = sum_layers(core->tables, core->point, of_core, {});
    add(section.n, inner.n), add(section.m, inner.m);
    out.thickness += inner.thickness, out.stress[kMiddle] = stress_at(inner.layers, 0.0, kSmooth);
  }
  const PlaneBasis basis(f.a);
  out.force = basis.push(section.n, 1.0 / area), out.moment = basis.push(section.m, 1.0 / area);
  out.normal = Vec3(f.normal.x, f.normal.y, f.normal.z);
  out.first = along.normalized(), out.second = out.normal.cross(out.first);
  return out;
}

void thicken(SectionState& section, double factor) {
  const auto times = [](Sym2<double>& a, double by) { a = {by * a.c11, by * a.c22, by * a.c12}; };
  times(section.force, factor), times(section.moment, factor * factor);
  section.thickness *= factor;
}

}  // namespace sunder::shell
