#include "shell/mechanics/point_force.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace sunder::shell {
namespace {

constexpr int kChunks = 4;  // fixed, so that sums do not depend on the number of threads

Forms<double> forms_of(const GatheredPoint& p, const Derivatives<double>& d) {
  Forms<double> f = surface_forms(d);
  if (p.kind == PointKind::kLinear) f.b = p.metric.b;  // no bending: curvature stays that of the rest state
  return f;
}

// Positions and forces of the gathered points stand as x y z and a padding, so that a function's control
// point is one load.
struct Tangents {
  Pack4 d[5] = {};  // u v uu vv uv, lanes x y z
};
Tangents gather_point(const GatheredPoint& p, const double* x4) {
  Tangents t;
  for (const GatheredFunction& f : p.functions) {
    const Pack4 x = load<Pack4>(x4 + kPointLanes * f.slot);
    for (int k = 0; k < 5; ++k) t.d[k] += f.n[k + 1] * x;
  }
  return t;
}

void scatter_point(const GatheredPoint& p, const Pack4* g, double* force4) {
  for (const GatheredFunction& f : p.functions) {
    double* to = force4 + kPointLanes * f.slot;
    Pack4 sum = load<Pack4>(to);
    for (int k = 0; k < 5; ++k) sum += f.n[k + 1] * g[k];
    store<Pack4>(to, sum);
  }
}

// 11 22 12 of the lower face, then of the upper.
std::array<double, 6> linear_stress(const double* n, const double* m, double thickness) {
  std::array<double, 6> six{};
  for (int k = 0; k < 3; ++k) {
    const double mean = n[k] / thickness, bend = 6.0 * m[k] / (thickness * thickness);
    six[k] = mean - bend, six[3 + k] = mean + bend;
  }
  return six;
}

void record_stress(const RowTables& t, const GatheredPoint& p, const std::array<double, 6>& now, SurfaceStress stress) {
  double s[6];
  for (int k = 0; k < 6; ++k) {
    double& mean = (*stress.values)[t.at(p.block, 6, k, p.lane)];
    s[k] = mean += stress.share * (now[k] - mean);
  }
  if (stress.over && std::max(most_tension(s[0], s[1], s[2]), most_tension(s[3], s[4], s[5])) >
                         kSurelyBelow * (*stress.least)[p.block])
    // points of one block may be in two threads' chunks
    std::atomic_ref((*stress.over)[p.block]).store(1, std::memory_order_relaxed);
}

// A field of a layer's plastic state at a point: change 11 22 12, strain.
double& plastic_field(const RowTables& t, const RowPlasticity& plastic, const GatheredPoint& p, std::size_t layer,
                      int field) {
  const int fields = 4 * static_cast<int>(t.layers.zeta.size());
  return (*plastic.states)[t.at(p.block, fields, 4 * static_cast<int>(layer) + field, p.lane)];
}

std::array<PlasticState<double>, kMostLayers> plastic_states(const RowTables& t, const RowPlasticity& plastic,
                                                             const GatheredPoint& p) {
  std::array<PlasticState<double>, kMostLayers> states;
  for (std::size_t l = 0; l < t.layers.zeta.size(); ++l) {
    const auto field = [&](int k) { return plastic_field(t, plastic, p, l, k); };
    states[l] = {{field(0), field(1), field(2)}, field(3)};
  }
  return states;
}

// `now` where the point did not bear.
Forms<double> last_forms(const RowTables& t, const RowPlasticity& plastic, const GatheredPoint& p,
                         const Forms<double>& now) {
  const auto field = [&](int k) { return (*plastic.forms)[t.at(p.block, kFormFields, k, p.lane)]; };
  if (!(field(0) > 0.0)) return now;
  Forms<double> f{};
  f.a = {field(0), field(1), field(2)}, f.b = {field(3), field(4), field(5)};
  return f;
}

void keep_forms(const RowTables& t, const RowPlasticity& plastic, const GatheredPoint& p, const Sym2<double>& a,
                const Sym2<double>& b) {
  const double now[kFormFields] = {a.c11, a.c22, a.c12, b.c11, b.c22, b.c12};
  for (int k = 0; k < kFormFields; ++k) (*plastic.forms)[t.at(p.block, kFormFields, k, p.lane)] = now[k];
}

void forget_forms(const RowTables& t, const RowPlasticity& plastic, const GatheredPoint& p) {
  (*plastic.forms)[t.at(p.block, kFormFields, 0, p.lane)] = -1.0;
}

// As many points side by side as a pack has lanes; returns their energy where asked for.
template <bool kEnergy>
double batch(const RowTables& t, const GatheredPoint* const* points, int count, const double* x4, double thickness,
             SurfaceStress stress, double* force4, PointDamage* const* damaged, const DamageLaw* law,
             const RowPlasticity* plastic, double& booked) {
  Pack d[5][3] = {};  // derivative, direction; a lane for each point
  ReferenceMetric<Pack> ref{};
  Pack area{};
  IntPack linear{};
  Tangents tangents;
  for (int i = 0; i < kLanes; ++i) {
    const GatheredPoint& p = *points[std::min(i, count - 1)];
    if (i < count) tangents = gather_point(p, x4), area[i] = p.area;  // lanes beyond repeat the last point
    for (int k = 0; k < 5; ++k)
      for (int c = 0; c < 3; ++c) d[k][c][i] = tangents.d[k][c];
    linear[i] = p.kind == PointKind::kLinear ? -1 : 0;
    ref.a.c11[i] = p.metric.a.c11, ref.a.c22[i] = p.metric.a.c22, ref.a.c12[i] = p.metric.a.c12;
    ref.b.c11[i] = p.metric.b.c11, ref.b.c22[i] = p.metric.b.c22, ref.b.c12[i] = p.metric.b.c12;
  }
  const auto vector = [&](int k) { return Vector<Pack>{d[k][0], d[k][1], d[k][2]}; };
  const Derivatives<Pack> x_d{vector(0), vector(1), vector(2), vector(3), vector(4)};
  Forms<Pack> f = surface_forms(x_d);
  // a linear basis has no bending: curvature stays that of the rest state
  const Pack none{};
  f.b = {select(linear, ref.b.c11, f.b.c11), select(linear, ref.b.c22, f.b.c22), select(linear, ref.b.c12, f.b.c12)};
  Resultants<Pack> r;
  Pack damage[kMostLayers];
  Resultants<Pack> lost{};
  PlasticState<Pack> states[kMostLayers];
  FaceStress<Pack> faces;
  Pack worked{};
  const std::size_t layers = t.layers.zeta.size();
  if (plastic) {
    for (std::size_t l = 0; l < layers; ++l)
      for (int i = 0; i < kLanes; ++i) {
        const GatheredPoint& p = *points[std::min(i, count - 1)];
        const auto field = [&](int k) { return plastic_field(t, *plastic, p, l, k); };
        PlasticState<Pack>& s = states[l];
        s.change.c11[i] = field(0), s.change.c22[i] = field(1), s.change.c12[i] = field(2), s.strain[i] = field(3);
      }
    Forms<Pack> last{};
    for (int i = 0; i < kLanes; ++i) {
      Forms<double> now{};
      now.a = {f.a.c11[i], f.a.c22[i], f.a.c12[i]}, now.b = {f.b.c11[i], f.b.c22[i], f.b.c12[i]};
      const Forms<double> own = last_forms(t, *plastic, *points[std::min(i, count - 1)], now);
      last.a.c11[i] = own.a.c11, last.a.c22[i] = own.a.c22, last.a.c12[i] = own.a.c12;
      last.b.c11[i] = own.b.c11, last.b.c22[i] = own.b.c22, last.b.c12[i] = own.b.c12;
    }
    r = (plastic->advance ? integrate_yielding_layers<Pack, kEnergy, true>
                          : integrate_yielding_layers<Pack, kEnergy, false>)(f, ref, t.layers, t.elasticity,
                                                                             plastic->law, states, worked, &faces,
                                                                             &last);
  } else if (damaged) {
    Pack strength;
    for (int i = 0; i < kLanes; ++i) strength[i] = damaged[std::min(i, count - 1)]->strength;
    if (!law->heals)
      for (int i = 0; i < kLanes; ++i)
        for (std::size_t l = 0; l < t.layers.zeta.size(); ++l)
          damage[l][i] = damaged[std::min(i, count - 1)]->history[l];
    const bool wanted = stress.values || kEnergy;
    const auto integrate = law->heals ? (wanted ? integrate_weakened_layers<Pack, kEnergy, true>
                                                : integrate_weakened_layers<Pack, kEnergy, false>)
                                      : (wanted ? integrate_weakened_layers<Pack, kEnergy, true, false>
                                                : integrate_weakened_layers<Pack, kEnergy, false, false>);
    r = integrate(f, ref, t.layers, t.elasticity, strength, law->brittleness, damage, lost);
  } else {
    r = integrate_layers<Pack, kEnergy>(f, ref, t.layers, t.elasticity);
  }
  r.m = {select(linear, none, r.m.c11), select(linear, none, r.m.c22), select(linear, none, r.m.c12)};
  const Derivatives<Pack> g = section_forces(x_d, f, r, area);
  const Vector<Pack> all[5] = {g.u, g.v, g.uu, g.vv, g.uv};
  const IntPack sound = bears(f, ref, t.layers);
  double sum = 0.0;
  for (int i = 0; i < count; ++i) {
    const double n[3] = {r.n.c11[i], r.n.c22[i], r.n.c12[i]}, m[3] = {r.m.c11[i], r.m.c22[i], r.m.c12[i]};
    if (!sound[i] || !std::isfinite(n[0] + n[1] + m[0] + m[1])) {
      if (damaged) damaged[i]->fresh = true;
      if (plastic && plastic->advance) forget_forms(t, *plastic, *points[i]);
      continue;
    }
    if constexpr (kEnergy) sum += points[i]->area * r.energy[i];
    if constexpr (kEnergy)  // what is not booked yet counts as stored
      if (plastic && !plastic->advance) sum += points[i]->area * worked[i];
    if (stress.values && plastic)
      record_stress(t, *points[i],
                    {faces.low.c11[i], faces.low.c22[i], faces.low.c12[i], faces.high.c11[i], faces.high.c22[i],
                     faces.high.c12[i]},
                    stress);
    else if (stress.values)
      record_stress(t, *points[i], linear_stress(n, m, thickness), stress);
    if (plastic && plastic->advance) {
      for (std::size_t l = 0; l < layers; ++l) {
        const PlasticState<Pack>& s = states[l];
        const double now[4] = {s.change.c11[i], s.change.c22[i], s.change.c12[i], s.strain[i]};
        for (int k = 0; k < 4; ++k) plastic_field(t, *plastic, *points[i], l, k) = now[k];
      }
      keep_forms(t, *plastic, *points[i], {f.a.c11[i], f.a.c22[i], f.a.c12[i]}, {f.b.c11[i], f.b.c22[i], f.b.c12[i]});
      booked += points[i]->area * worked[i];
    }
    if (damaged) {
      PointDamage& d = *damaged[i];
      const Loss loss = loss_of(f, lost, i);
      const double retained = kEnergy && law->heals ? d.retained + retained_since(d, loss, points[i]->area) : 0.0;
      if (stress.values) {
        for (std::size_t l = 0; l < t.layers.zeta.size(); ++l) {
          d.now[l] = static_cast<float>(damage[l][i]);
          d.history[l] = std::max(d.history[l], d.now[l]);
        }
        booked += (law->heals ? keep : keep_worst)(d, loss, points[i]->area);
      }
      if constexpr (kEnergy) sum -= law->heals ? retained : d.retained + retained_since(d, loss, points[i]->area);
    }
    Pack4 own[5];
    for (int k = 0; k < 5; ++k) own[k] = Pack4{all[k].x[i], all[k].y[i], all[k].z[i], 0.0};
    scatter_point(*points[i], own, force4);
  }
  return sum;
}

double chunk(const RowTables& t, const std::vector<GatheredPoint>& points, std::size_t begin, std::size_t end,
             const double* x4, bool energy, SurfaceStress stress, double* force4, DamageLaw* law,
             const RowPlasticity* plastic, double& booked) {
  double sum = 0.0, thickness = 0.0;
  for (const double w : t.layers.weight) thickness += w;
  const GatheredPoint* together[kLanes];
  PointDamage* damaged[kLanes] = {};
  int count = 0;
  for (std::size_t i = begin; i < end; ++i) {
    if (points[i].kind != PointKind::kDead && !points[i].in_rows) {
      if (law) damaged[count] = &(*law->points)[i];
      together[count++] = &points[i];
    }
    if (count < kLanes && (i + 1 < end || count == 0)) continue;
    sum += (energy ? batch<true> : batch<false>)(t, together, count, x4, thickness, stress, force4,
                                                 law ? damaged : nullptr, law, plastic, booked);
    count = 0;
  }
  return sum;
}

}  // namespace

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
  double d[5][3] = {};
  for (const GatheredFunction& f : p.functions)
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < 5; ++k) d[k][c] += f.n[k + 1] * x[static_cast<std::size_t>(c) * t.plane + f.slot];
  const auto vector = [&](int k) { return Vector<double>{d[k][0], d[k][1], d[k][2]}; };
  return {vector(0), vector(1), vector(2), vector(3), vector(4)};
}

namespace {

// A damaged point as it stands, and what weakening takes.
Resultants<double> weakened(const RowTables& t, const GatheredPoint& p, const Forms<double>& f, const PointDamage& d,
                            double brittleness, bool heals, Loss& loss) {
  double damage[kMostLayers];
  std::copy(d.history.begin(), d.history.end(), damage);
  Resultants<double> lost{};
  const auto integrate =
      heals ? integrate_weakened_layers<double, true, true> : integrate_weakened_layers<double, true, true, false>;
  const Resultants<double> r = integrate(f, p.metric, t.layers, t.elasticity, d.strength, brittleness, damage, lost);
  loss = loss_of(f, lost, 0);
  return r;
}

}  // namespace

void settle(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x, double brittleness,
            PointDamage& d) {
  if (p.kind == PointKind::kDead) return;
  const Forms<double> f = forms_of(p, gather(t, p, x));
  if (!bears(f, p.metric, t.layers)) return;
  Loss loss;
  weakened(t, p, f, d, brittleness, false, loss);
  keep_worst(d, loss, p.area);
}

std::optional<Derivatives<double>> point_force(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x,
                                               double times, const PointDamage* damage, double brittleness, bool heals,
                                               const RowPlasticity* plastic) {
  if (p.kind == PointKind::kDead) return {};
  const Derivatives<double> d = gather(t, p, x);
  const Forms<double> f = forms_of(p, d);
  if (!bears(f, p.metric, t.layers)) return {};
  Resultants<double> r;
  if (plastic) {
    auto states = plastic_states(t, *plastic, p);
    const Forms<double> last = last_forms(t, *plastic, p, f);
    double unused = 0.0;
    r = integrate_yielding_layers<double, false, false>(f, p.metric, t.layers, t.elasticity, plastic->law,
                                                        states.data(), unused, nullptr, &last);
  } else if (damage) {
    Loss loss;
    r = weakened(t, p, f, *damage, brittleness, heals, loss);
  } else {
    r = integrate_layers<double, false>(f, p.metric, t.layers, t.elasticity);
  }
  if (!std::isfinite(r.n.c11 + r.n.c22 + r.m.c11 + r.m.c22)) return {};
  if (p.kind == PointKind::kLinear) r.m = {0.0, 0.0, 0.0};
  return section_forces(d, f, r, times * p.area);
}

void spread(const RowTables& t, const GatheredPoint& p, const Derivatives<double>& g, int k,
            std::vector<double>& force) {
  const auto along = [&](const Vector<double>& v) { return k == 0 ? v.x : k == 1 ? v.y : v.z; };
  const double all[5] = {along(g.u), along(g.v), along(g.uu), along(g.vv), along(g.uv)};
  double* const plane = force.data() + static_cast<std::size_t>(k) * t.plane;
  for (const GatheredFunction& f : p.functions)
    for (int i = 0; i < 5; ++i) plane[f.slot] += f.n[i + 1] * all[i];
}

double point_energy(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x, const PointDamage* damage,
                    double brittleness, bool heals) {
  if (p.kind == PointKind::kDead) return 0.0;
  const Forms<double> f = forms_of(p, gather(t, p, x));
  if (!bears(f, p.metric, t.layers)) return 0.0;
  double energy = 0.0;
  if (damage) {
    Loss loss;
    energy = p.area * weakened(t, p, f, *damage, brittleness, heals, loss).energy;
    energy -= damage->retained + retained_since(*damage, loss, p.area);
  } else {
    energy = p.area * integrate_layers<double, true>(f, p.metric, t.layers, t.elasticity).energy;
  }
  return std::isfinite(energy) ? energy : 0.0;
}

double point_energy(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x,
                    const RowPlasticity& plastic) {
  if (p.kind == PointKind::kDead) return 0.0;
  const Forms<double> f = forms_of(p, gather(t, p, x));
  if (!bears(f, p.metric, t.layers)) return 0.0;
  auto states = plastic_states(t, plastic, p);
  double unused = 0.0;
  const double energy = p.area * integrate_yielding_layers<double, true, false>(f, p.metric, t.layers, t.elasticity,
                                                                                plastic.law, states.data(), unused)
                                     .energy;
  return std::isfinite(energy) ? energy : 0.0;
}

double settle(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x, const RowPlasticity& plastic) {
  if (p.kind == PointKind::kDead) return 0.0;
  const Forms<double> f = forms_of(p, gather(t, p, x));
  if (!bears(f, p.metric, t.layers)) {
    forget_forms(t, plastic, p);
    return 0.0;
  }
  auto states = plastic_states(t, plastic, p);
  const std::size_t layers = t.layers.zeta.size();
  if (p.kind == PointKind::kLinear) {
    PlasticState<double> mean{{0.0, 0.0, 0.0}, 0.0};
    double thickness = 0.0;
    for (const double w : t.layers.weight) thickness += w;
    for (std::size_t l = 0; l < layers; ++l) {
      const double share = t.layers.weight[l] / thickness;
      mean.change.c11 += share * states[l].change.c11, mean.change.c22 += share * states[l].change.c22;
      mean.change.c12 += share * states[l].change.c12, mean.strain += share * states[l].strain;
    }
    std::fill_n(states.begin(), layers, mean);
  }
  double work = 0.0;
  const Forms<double> last = last_forms(t, plastic, p, f);
  integrate_yielding_layers<double, false, true>(f, p.metric, t.layers, t.elasticity, plastic.law, states.data(), work,
                                                 nullptr, &last);
  keep_forms(t, plastic, p, f.a, f.b);
  for (std::size_t l = 0; l < layers; ++l) {
    const PlasticState<double>& s = states[l];
    const double now[4] = {s.change.c11, s.change.c22, s.change.c12, s.strain};
    for (int k = 0; k < 4; ++k) plastic_field(t, plastic, p, l, k) = now[k];
  }
  return p.area * work;
}

std::array<double, 6> undamaged_stress(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x) {
  std::array<double, 6> six{};
  if (p.kind == PointKind::kDead) return six;
  const Forms<double> f = forms_of(p, gather(t, p, x));
  if (!bears(f, p.metric, t.layers)) return six;
  const Resultants<double> r = integrate_layers<double, false>(f, p.metric, t.layers, t.elasticity);
  double thickness = 0.0;
  for (const double w : t.layers.weight) thickness += w;
  const double n[3] = {r.n.c11, r.n.c22, r.n.c12}, none[3] = {};
  const double m[3] = {r.m.c11, r.m.c22, r.m.c12};
  return linear_stress(n, p.kind == PointKind::kLinear ? none : m, thickness);
}

double add_point_forces(const RowTables& t, const std::vector<GatheredPoint>& points, const std::vector<double>& x,
                        bool energy, SurfaceStress stress, int threads, std::vector<double>& scratch,
                        std::vector<double>& force, DamageLaw* damage, RowPlasticity* plastic,
                        const PointsBeside& beside) {
  if (points.empty() && !beside) return 0.0;
  const std::size_t plane = t.plane, size = kPointLanes * plane;
  scratch.resize((kChunks + 1) * size);
  double* x4 = scratch.data() + kChunks * size;
  for (std::size_t i = 0; i < plane; ++i) {
    for (int c = 0; c < 3; ++c) x4[kPointLanes * i + c] = x[c * plane + i];
    x4[kPointLanes * i + 3] = 0.0;
  }
  double sums[kChunks] = {}, booked[kChunks] = {};
#pragma omp parallel for schedule(static, 1) num_threads(std::min(threads, kChunks))
  for (int c = 0; c < kChunks; ++c) {
    double* own = scratch.data() + c * size;
    std::fill(own, own + size, 0.0);
    sums[c] = chunk(t, points, points.size() * c / kChunks, points.size() * (c + 1) / kChunks, x4, energy, stress, own,
                    damage, plastic, booked[c]);
    if (beside) beside(c, kChunks, x4, own);
  }
  double sum = 0.0;
  for (int c = 0; c < kChunks; ++c) {
    sum += sums[c];
    if (plastic) plastic->dissipated += booked[c];
    if (damage) (damage->heals ? damage->healed : damage->dissipated) += booked[c];
    const double* own = scratch.data() + c * size;
    for (int d = 0; d < 3; ++d)
      for (std::size_t i = 0; i < plane; ++i) force[d * plane + i] += own[kPointLanes * i + d];
  }
  return sum;
}

}  // namespace sunder::shell
