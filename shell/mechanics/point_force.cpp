#include "shell/mechanics/point_force.h"

#include <algorithm>
#include <cmath>

namespace sunder::shell {
namespace {

constexpr double kCrushed = 0.04;  // of the reference metric's determinant: squeezed to a fifth of its area
constexpr int kChunks = 4;         // fixed, so that sums do not depend on the number of threads

Forms<double> forms_of(const GatheredPoint& p, const Derivatives<double>& d) {
  Forms<double> f = surface_forms(d);
  if (p.kind == PointKind::kLinear) f.b = p.metric.b;  // no bending: curvature stays that of the rest state
  return f;
}

// Derivatives of the positions at one point: u v uu vv uv of x, then of y, then of z.
void gather_point(const RowTables& t, const GatheredPoint& p, const double* x, double* out) {
  Pack sum[15] = {};
  const std::size_t plane = t.plane;
  for (const FunctionBlock& f : p.blocks)
    for (int c = 0; c < 3; ++c) {
      const double* from = x + c * plane;
      const Pack v{from[f.slot[0]], from[f.slot[1]], from[f.slot[2]], from[f.slot[3]]};
      for (int k = 0; k < 5; ++k) sum[5 * c + k] += load<Pack>(f.n[k]) * v;
    }
  for (int k = 0; k < 15; ++k) out[k] = (sum[k][0] + sum[k][1]) + (sum[k][2] + sum[k][3]);
}

void scatter_point(const RowTables& t, const GatheredPoint& p, const double* g, double* force) {
  const std::size_t plane = t.plane;
  for (const FunctionBlock& f : p.blocks)
    for (int c = 0; c < 3; ++c) {
      Pack sum{};
      for (int k = 0; k < 5; ++k) sum += load<Pack>(f.n[k]) * g[5 * c + k];
      double* to = force + c * plane;
      for (int i = 0; i < kLanes; ++i) to[f.slot[i]] += sum[i];
    }
}

Derivatives<Pack> derivatives(const Pack* d) {
  return {{d[0], d[5], d[10]}, {d[1], d[6], d[11]}, {d[2], d[7], d[12]}, {d[3], d[8], d[13]}, {d[4], d[9], d[14]}};
}

void record_stress(const RowTables& t, const GatheredPoint& p, const double* n, const double* m, double thickness,
                   SurfaceStress stress) {
  for (int k = 0; k < 3; ++k) {
    const double mean = n[k] / thickness, bend = 6.0 * m[k] / (thickness * thickness);
    double& low = (*stress.values)[t.at(p.block, 6, k, p.lane)];
    double& high = (*stress.values)[t.at(p.block, 6, 3 + k, p.lane)];
    low += stress.share * (mean - bend - low);
    high += stress.share * (mean + bend - high);
  }
}

// Up to four points side by side; returns their energy where asked for.
template <bool kEnergy>
double batch(const RowTables& t, const GatheredPoint* const* points, int count, const double* x, double thickness,
             SurfaceStress stress, double* force) {
  double lanes[15][kLanes] = {};
  ReferenceMetric<Pack> ref{};
  Pack area{};
  IntPack linear{};
  for (int i = 0; i < kLanes; ++i) {
    const GatheredPoint& p = *points[std::min(i, count - 1)];
    if (i < count) {
      double d[15];
      gather_point(t, p, x, d);
      for (int k = 0; k < 15; ++k) lanes[k][i] = d[k];
      area[i] = p.area;
    } else {
      for (int k = 0; k < 15; ++k) lanes[k][i] = lanes[k][0];
    }
    linear[i] = p.kind == PointKind::kLinear ? -1 : 0;
    ref.a.c11[i] = p.metric.a.c11, ref.a.c22[i] = p.metric.a.c22, ref.a.c12[i] = p.metric.a.c12;
    ref.b.c11[i] = p.metric.b.c11, ref.b.c22[i] = p.metric.b.c22, ref.b.c12[i] = p.metric.b.c12;
  }
  Pack d[15];
  for (int k = 0; k < 15; ++k) d[k] = load<Pack>(lanes[k]);
  const Derivatives<Pack> x_d = derivatives(d);
  Forms<Pack> f = surface_forms(x_d);
  // a linear basis has no bending: curvature stays that of the rest state
  const Pack none{};
  f.b = {select(linear, ref.b.c11, f.b.c11), select(linear, ref.b.c22, f.b.c22), select(linear, ref.b.c12, f.b.c12)};
  Resultants<Pack> r = integrate_layers<Pack, kEnergy>(f, ref, t.layers, t.elasticity);
  r.m = {select(linear, none, r.m.c11), select(linear, none, r.m.c22), select(linear, none, r.m.c12)};
  const Derivatives<Pack> g = section_forces(x_d, f, r, area);
  const Pack all[15] = {g.u.x,  g.v.x,  g.uu.x, g.vv.x, g.uv.x, g.u.y,  g.v.y, g.uu.y,
                        g.vv.y, g.uv.y, g.u.z,  g.v.z,  g.uu.z, g.vv.z, g.uv.z};
  const Pack ratio = determinant(f.a) / determinant(ref.a);
  double sum = 0.0;
  for (int i = 0; i < count; ++i) {
    const double n[3] = {r.n.c11[i], r.n.c22[i], r.n.c12[i]}, m[3] = {r.m.c11[i], r.m.c22[i], r.m.c12[i]};
    // A point crushed between cracks (an area ratio that has turned over) has no stress: it carries nothing.
    if (!(ratio[i] > kCrushed) || !std::isfinite(n[0] + n[1] + m[0] + m[1])) continue;
    if constexpr (kEnergy) sum += points[i]->area * r.energy[i];
    if (stress.values) record_stress(t, *points[i], n, m, thickness, stress);
    double own[15];
    for (int k = 0; k < 15; ++k) own[k] = all[k][i];
    scatter_point(t, *points[i], own, force);
  }
  return sum;
}

double chunk(const RowTables& t, const std::vector<GatheredPoint>& points, std::size_t begin, std::size_t end,
             const std::vector<double>& x, bool energy, SurfaceStress stress, double* force) {
  double sum = 0.0, thickness = 0.0;
  for (const double w : t.layers.weight) thickness += w;
  const GatheredPoint* four[kLanes];
  int count = 0;
  for (std::size_t i = begin; i < end; ++i) {
    if (points[i].kind != PointKind::kDead) four[count++] = &points[i];
    if (count < kLanes && (i + 1 < end || count == 0)) continue;
    sum += (energy ? batch<true> : batch<false>)(t, four, count, x.data(), thickness, stress, force);
    count = 0;
  }
  return sum;
}

}  // namespace

void set_functions(GatheredPoint& p, std::vector<GatheredFunction> functions) {
  p.functions = std::move(functions);
  p.blocks.assign((p.functions.size() + kLanes - 1) / kLanes, {});
  for (std::size_t i = 0; i < p.blocks.size() * kLanes; ++i) {
    FunctionBlock& b = p.blocks[i / kLanes];
    const bool pad = i >= p.functions.size();
    b.slot[i % kLanes] = p.functions[pad ? 0 : i].slot;
    for (int k = 0; k < 5; ++k) b.n[k][i % kLanes] = pad ? 0.0 : p.functions[i].n[k + 1];
  }
}

Derivatives<double> gather(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x) {
  double d[15];
  gather_point(t, p, x.data(), d);
  return {{d[0], d[5], d[10]}, {d[1], d[6], d[11]}, {d[2], d[7], d[12]}, {d[3], d[8], d[13]}, {d[4], d[9], d[14]}};
}

double point_energy(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x) {
  if (p.kind == PointKind::kDead) return 0.0;
  const Forms<double> f = forms_of(p, gather(t, p, x));
  if (!(determinant(f.a) > kCrushed * determinant(p.metric.a))) return 0.0;
  const double energy = p.area * integrate_layers<double, true>(f, p.metric, t.layers, t.elasticity).energy;
  return std::isfinite(energy) ? energy : 0.0;
}

double add_point_forces(const RowTables& t, const std::vector<GatheredPoint>& points, const std::vector<double>& x,
                        bool energy, SurfaceStress stress, int threads, std::vector<double>& scratch,
                        std::vector<double>& force) {
  if (points.empty()) return 0.0;
  const std::size_t size = force.size();
  scratch.resize(kChunks * size);
  double sums[kChunks] = {};
#pragma omp parallel for schedule(static, 1) num_threads(std::min(threads, kChunks))
  for (int c = 0; c < kChunks; ++c) {
    double* own = scratch.data() + c * size;
    std::fill(own, own + size, 0.0);
    sums[c] = chunk(t, points, points.size() * c / kChunks, points.size() * (c + 1) / kChunks, x, energy, stress, own);
  }
  double sum = 0.0;
  for (int c = 0; c < kChunks; ++c) {
    sum += sums[c];
    const double* own = scratch.data() + c * size;
    for (std::size_t i = 0; i < size; ++i) force[i] += own[i];
  }
  return sum;
}

}  // namespace sunder::shell
