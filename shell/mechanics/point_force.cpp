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

double chunk(const RowTables& t, const std::vector<GatheredPoint>& points, std::size_t begin, std::size_t end,
             const std::vector<double>& x, bool energy, SurfaceStress stress, double* force) {
  double sum = 0.0, thickness = 0.0;
  for (const double w : t.layers.weight) thickness += w;
  for (std::size_t i = begin; i < end; ++i) {
    const GatheredPoint& p = points[i];
    if (p.kind == PointKind::kDead) continue;
    const Derivatives<double> d = gather(t, p.functions, x);
    const Forms<double> f = forms_of(p, d);
    Resultants<double> r = energy ? integrate_layers<double, true>(f, p.metric, t.layers, t.elasticity)
                                  : integrate_layers<double, false>(f, p.metric, t.layers, t.elasticity);
    if (p.kind == PointKind::kLinear) r.m = {0.0, 0.0, 0.0};
    // A point crushed between cracks (an area ratio that has turned over) has no stress: it carries nothing.
    if (!(determinant(f.a) > kCrushed * determinant(p.metric.a)) ||
        !std::isfinite(r.n.c11 + r.n.c22 + r.m.c11 + r.m.c22))
      continue;
    sum += p.area * r.energy;
    if (stress.values) {
      const double n[3] = {r.n.c11, r.n.c22, r.n.c12}, m[3] = {r.m.c11, r.m.c22, r.m.c12};
      for (int k = 0; k < 3; ++k) {
        const double mean = n[k] / thickness, bend = 6.0 * m[k] / (thickness * thickness);
        double& low = (*stress.values)[t.at(p.block, 6, k, p.lane)];
        double& high = (*stress.values)[t.at(p.block, 6, 3 + k, p.lane)];
        low += stress.share * (mean - bend - low);
        high += stress.share * (mean + bend - high);
      }
    }
    const Derivatives<double> g = section_forces(d, f, r, p.area);
    const double gx[15] = {g.u.x,  g.v.x,  g.uu.x, g.vv.x, g.uv.x, g.u.y,  g.v.y, g.uu.y,
                           g.vv.y, g.uv.y, g.u.z,  g.v.z,  g.uu.z, g.vv.z, g.uv.z};
    for (const GatheredFunction& s : p.functions)
      for (int c = 0; c < 3; ++c) {
        const double* h = gx + 5 * c;
        force[static_cast<std::size_t>(c) * t.plane + s.slot] +=
            s.n[1] * h[0] + s.n[2] * h[1] + s.n[3] * h[2] + s.n[4] * h[3] + s.n[5] * h[4];
      }
  }
  return sum;
}

}  // namespace

Derivatives<double> gather(const RowTables& t, const std::vector<GatheredFunction>& functions,
                           const std::vector<double>& x) {
  double d[15] = {};
  for (const GatheredFunction& s : functions)
    for (int c = 0; c < 3; ++c) {
      const double v = x[static_cast<std::size_t>(c) * t.plane + s.slot];
      for (int k = 0; k < 5; ++k) d[3 * k + c] += s.n[k + 1] * v;
    }
  return {{d[0], d[1], d[2]}, {d[3], d[4], d[5]}, {d[6], d[7], d[8]}, {d[9], d[10], d[11]}, {d[12], d[13], d[14]}};
}

double point_energy(const RowTables& t, const GatheredPoint& p, const std::vector<double>& x) {
  if (p.kind == PointKind::kDead) return 0.0;
  const Forms<double> f = forms_of(p, gather(t, p.functions, x));
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
