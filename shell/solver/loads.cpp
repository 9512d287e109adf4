#include "shell/solver/loads.h"

#include <algorithm>

#include "coupler/core/error.h"
#include "shell/geometry/parameter_place.h"
#include "shell/geometry/quadrature.h"
#include "shell/mechanics/row_pressure.h"
#include "shell/solver/supports.h"

namespace sunder::shell {
namespace {

void edge_samples(const Patch& patch, int edge, int stride, std::vector<LoadSample>& out) {
  const bool along_u = edge >= kVMin;
  const KnotVector& k = along_u ? patch.knots_u : patch.knots_v;
  const GaussRule& rule = gauss_rule(3);
  const double fixed = edge == kUMin   ? patch.knots_u.begin()
                       : edge == kUMax ? patch.knots_u.end()
                       : edge == kVMin ? patch.knots_v.begin()
                                       : patch.knots_v.end();
  for (int s = 0; s < k.spans(); ++s)
    for (int a = 0; a < 3 && k.span_length(s) > 0.0; ++a) {
      const double at = k.span_begin(s) + 0.5 * (1.0 + rule.point[a]) * k.span_length(s);
      const Vec2 p = along_u ? Vec2(at, fixed) : Vec2(fixed, at);
      const SurfacePoint q = patch.evaluate(p);
      LoadSample sample;
      sample.at = p;
      sample.functions = patch_functions(patch, p, stride);
      sample.weight = 0.5 * rule.weight[a] * k.span_length(s) * (along_u ? q.u : q.v).norm();
      sample.along_u = along_u;
      sample.outward = edge == kVMin || edge == kUMax ? 1.0 : -1.0;
      out.push_back(std::move(sample));
    }
}

}  // namespace

double factor_at(const TimeFactor& f, double time) {
  if (f.empty()) return 1.0;
  if (time <= f.front().first) return f.front().second;
  for (std::size_t i = 1; i < f.size(); ++i)
    if (time < f[i].first)
      return f[i - 1].second +
             (time - f[i - 1].first) / (f[i].first - f[i - 1].first) * (f[i].second - f[i - 1].second);
  return f.back().second;
}

bool PreparedLoads::rotate_with_surface() const {
  return !pressures.empty() || std::any_of(beside.begin(), beside.end(), [](const PreparedLoad& p) {
    return p.load.kind == Load::Kind::kEdgeMoment;
  });
}

double PreparedLoads::last_change() const {
  double last = 0.0;
  const auto look = [&](const Load& load) {
    if (!load.in_time.empty()) last = std::max(last, load.in_time.back().first);
  };
  for (const PreparedLoad& p : beside) look(p.load);
  for (const Load& load : pressures) look(load);
  return last;
}

PreparedLoads prepare_loads(const Patch& patch, const RowTables& t, const std::vector<Load>& loads,
                            const std::string& name) {
  PreparedLoads out;
  const int stride = t.stride;
  for (const Load& load : loads) {
    if (load.kind == Load::Kind::kPressure) {
      out.pressures.push_back(load);
      continue;
    }
    PreparedLoad p{load, {}};
    if (load.kind == Load::Kind::kPoint) {
      p.load.point = moved_onto_edges(patch, load.point);
      require(patch.contains(p.load.point),
              "{}: a load at ({:.9g}, {:.9g}) lies outside the patch, whose parameters run {}", name, load.point.x(),
              load.point.y(), parameter_range(patch));
      p.samples.push_back({p.load.point, patch_functions(patch, p.load.point, stride)});
    } else {
      for (const int edge : {kUMin, kUMax, kVMin, kVMax})
        if (load.edges & edge) edge_samples(patch, edge, stride, p.samples);
      require(!p.samples.empty(), "{}: an edge load names no edge", name);
    }
    out.beside.push_back(std::move(p));
  }
  if (out.pressures.empty()) return out;
  out.area.assign(static_cast<std::size_t>(t.blocks()) * t.lanes, 0.0);
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e)
      out.area[static_cast<std::size_t>(q) * t.lanes + e] = gauss_point(patch, t, q, e).weight;
  return out;
}

namespace {

void add_load(const PreparedLoad& p, const RowTables& t, double time, const std::vector<double>& x,
              std::vector<double>& force) {
  const double factor = factor_at(p.load.in_time, time);
  if (factor == 0.0) return;
  const std::size_t component_stride = t.component_stride;
  for (const LoadSample& sample : p.samples) {
    const auto add = [&](const GatheredFunction& n, const Vec3& f) {
      for (int d = 0; d < 3; ++d) force[d * component_stride + n.slot] += f[d];
    };
    if (p.load.kind != Load::Kind::kEdgeMoment) {
      for (const GatheredFunction& n : sample.functions) add(n, factor * sample.weight * n.n[0] * p.load.force);
      continue;
    }
    Vec3 xu = Vec3::Zero(), xv = Vec3::Zero();
    for (const GatheredFunction& f : sample.functions)
      for (int d = 0; d < 3; ++d)
        xu[d] += f.n[1] * x[d * component_stride + f.slot], xv[d] += f.n[2] * x[d * component_stride + f.slot];
    const Vec3 cross = xu.cross(xv);
    // A rotation w about the edge's tangent t changes the normal by w t x n. The normal changes by -(n . dx_a) x^a, so
    // w = -(n . dx_a) (x^a . t x n). The moment's work is M w.
    const Vec3 normal = cross.normalized(), tangent = sample.outward * (sample.along_u ? xu : xv).normalized();
    const Vec3 out = tangent.cross(normal);  // in the tangent plane, away from the patch
    const double square = cross.squaredNorm();
    const Vec3 du = xv.cross(cross) / square, dv = cross.cross(xu) / square;  // dual tangents
    const double moment = factor * sample.weight * p.load.size;
    for (const GatheredFunction& n : sample.functions)
      add(n, moment * (n.n[1] * du.dot(out) + n.n[2] * dv.dot(out)) * normal);
  }
}

}  // namespace

void load_forces(const PreparedLoads& loads, const RowTables& t, const std::vector<GatheredPoint>& points, double time,
                 const std::vector<double>& x, int threads, RowScratch& scratch, std::vector<double>& force) {
  force.resize(3 * static_cast<std::size_t>(t.component_stride));
  double pressure = 0.0;
  for (const Load& load : loads.pressures) pressure += factor_at(load.in_time, time) * load.size;
  if (pressure != 0.0)
    pressure_forces(t, loads.area, points, pressure, x, threads, scratch, force);
  else
    std::fill(force.begin(), force.end(), 0.0);
  for (const PreparedLoad& load : loads.beside) add_load(load, t, time, x, force);
}

}  // namespace sunder::shell
