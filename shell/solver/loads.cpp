#include "shell/solver/loads.h"

#include "coupler/core/error.h"
#include "shell/geometry/quadrature.h"
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

std::vector<PreparedLoad> prepare_loads(const Patch& patch, const RowTables& t, const std::vector<Load>& loads,
                                        const std::string& name) {
  std::vector<PreparedLoad> out;
  const int stride = t.stride;
  for (const Load& load : loads) {
    PreparedLoad p{load, {}};
    if (load.kind == Load::Kind::kPoint) {
      require(patch.contains(load.point),
              "{}: a load at ({:.6g}, {:.6g}) lies outside the patch, whose parameters run to ({:.6g}, {:.6g})", name,
              load.point.x(), load.point.y(), patch.knots_u.end(), patch.knots_v.end());
      p.samples.push_back({patch_functions(patch, load.point, stride)});
    } else if (load.kind == Load::Kind::kPressure) {
      for (int q = 0; q < t.blocks(); ++q)
        for (int e = 0; e < t.spans_u; ++e) {
          const GaussPoint g = gauss_point(patch, t, q, e);
          if (g.weight > 0.0)
            p.samples.push_back({patch_functions(patch, g.parameter, stride), g.weight, 0.0, false, q, e});
        }
    } else {
      for (const int edge : {kUMin, kUMax, kVMin, kVMax})
        if (load.edges & edge) edge_samples(patch, edge, stride, p.samples);
      require(!p.samples.empty(), "{}: an edge load names no edge", name);
    }
    out.push_back(std::move(p));
  }
  return out;
}

void add_load(const PreparedLoad& p, const RowTables& t, const std::vector<GatheredPoint>& points,
              const std::vector<int>& point_of, double time, const std::vector<double>& x, std::vector<double>& force) {
  const double factor = factor_at(p.load.in_time, time);
  if (factor == 0.0) return;
  const std::size_t plane = t.plane;
  for (const LoadSample& sample : p.samples) {
    const std::vector<GatheredFunction>* n = &sample.functions;
    if (sample.block >= 0) {
      const int point = point_of[static_cast<std::size_t>(sample.block) * t.lanes + sample.lane];
      if (point >= 0) n = &points[point].functions;  // none where it is dead
    }
    const auto add = [&](std::size_t k, const Vec3& f) {
      for (int d = 0; d < 3; ++d) force[d * plane + (*n)[k].slot] += f[d];
    };
    if (p.load.kind == Load::Kind::kPoint || p.load.kind == Load::Kind::kEdgeForce) {
      for (std::size_t k = 0; k < n->size(); ++k) add(k, factor * sample.weight * (*n)[k].n[0] * p.load.force);
      continue;
    }
    Vec3 xu = Vec3::Zero(), xv = Vec3::Zero();
    for (const GatheredFunction& f : *n)
      for (int d = 0; d < 3; ++d) xu[d] += f.n[1] * x[d * plane + f.slot], xv[d] += f.n[2] * x[d * plane + f.slot];
    const Vec3 cross = xu.cross(xv);
    if (p.load.kind == Load::Kind::kPressure) {
      for (std::size_t k = 0; k < n->size(); ++k) add(k, factor * p.load.size * sample.weight * (*n)[k].n[0] * cross);
      continue;
    }
    // A turn w about the edge's tangent t changes the normal by w t x n, and the normal changes by
    // -(n . dx_a) x^a: w = -(n . dx_a) (x^a . t x n), and the moment's work is M w.
    const Vec3 normal = cross.normalized(), tangent = sample.outward * (sample.along_u ? xu : xv).normalized();
    const Vec3 out = tangent.cross(normal);  // out of the patch, in its plane
    const double square = cross.squaredNorm();
    const Vec3 du = xv.cross(cross) / square, dv = cross.cross(xu) / square;  // dual tangents
    const double moment = factor * sample.weight * p.load.size;
    for (std::size_t k = 0; k < n->size(); ++k)
      add(k, moment * ((*n)[k].n[1] * du.dot(out) + (*n)[k].n[2] * dv.dot(out)) * normal);
  }
}

}  // namespace sunder::shell
