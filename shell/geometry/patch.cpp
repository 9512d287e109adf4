#include "shell/geometry/patch.h"

#include <cmath>

#include "coupler/core/error.h"
#include "shell/geometry/quadrature.h"

namespace sunder::shell {

bool Patch::rational() const {
  for (const double w : weights)
    if (w != weights.front()) return true;
  return false;
}

ShapeFunctions Patch::shape_functions(const Vec2& p) const {
  ShapeFunctions s;
  s.span_u = knots_u.span_of(p.x());
  s.span_v = knots_v.span_of(p.y());
  const Basis bu = knots_u.basis(s.span_u, p.x()), bv = knots_v.basis(s.span_v, p.y());
  double w = 0, wu = 0, wv = 0, wuu = 0, wvv = 0, wuv = 0;  // denominator and its derivatives
  for (int j = 0; j < kSupport; ++j)
    for (int i = 0; i < kSupport; ++i) {
      const int k = kSupport * j + i;
      const double weight = weights[(s.span_v + j) * columns() + s.span_u + i];
      w += s.value[k] = weight * bu.value[i] * bv.value[j];
      wu += s.u[k] = weight * bu.first[i] * bv.value[j];
      wv += s.v[k] = weight * bu.value[i] * bv.first[j];
      wuu += s.uu[k] = weight * bu.second[i] * bv.value[j];
      wvv += s.vv[k] = weight * bu.value[i] * bv.second[j];
      wuv += s.uv[k] = weight * bu.first[i] * bv.first[j];
    }
  for (int k = 0; k < 9; ++k) {  // quotient rule, highest derivatives last
    const double r = s.value[k] / w;
    const double ru = (s.u[k] - wu * r) / w, rv = (s.v[k] - wv * r) / w;
    s.uu[k] = (s.uu[k] - 2.0 * wu * ru - wuu * r) / w;
    s.vv[k] = (s.vv[k] - 2.0 * wv * rv - wvv * r) / w;
    s.uv[k] = (s.uv[k] - wu * rv - wv * ru - wuv * r) / w;
    s.value[k] = r, s.u[k] = ru, s.v[k] = rv;
  }
  return s;
}

SurfacePoint Patch::evaluate(const Vec2& p, const std::vector<Vec3>& net) const {
  const ShapeFunctions s = shape_functions(p);
  SurfacePoint q{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  for (int k = 0; k < 9; ++k) {
    const Vec3& x = net[(s.span_v + k / kSupport) * columns() + s.span_u + k % kSupport];
    q.x += s.value[k] * x, q.u += s.u[k] * x, q.v += s.v[k] * x;
    q.uu += s.uu[k] * x, q.vv += s.vv[k] * x, q.uv += s.uv[k] * x;
  }
  return q;
}

void validate(const Patch& patch, const std::string& field) {
  const std::size_t expected = static_cast<std::size_t>(patch.columns()) * patch.rows();
  require(
      patch.control_points.size() == expected,
      "{}.control_points: {} points, but the knots ask for {} x {} = {}; a quadratic direction has three knots more "
      "than control points",
      field, patch.control_points.size(), patch.columns(), patch.rows(), expected);
  require(patch.weights.size() == expected, "{}.weights: {} weights for {} control points; give one each, or none",
          field, patch.weights.size(), expected);
  for (std::size_t i = 0; i < expected; ++i) {
    require(patch.control_points[i].allFinite(), "{}.control_points[{}] is not a finite point", field, i);
    require(std::isfinite(patch.weights[i]) && patch.weights[i] > 0.0, "{}.weights[{}] is {}; weights are positive",
            field, i, patch.weights[i]);
  }
}

Patch with_parameters_as_lengths(const Patch& patch) {
  const GaussRule& rule = gauss_rule(2);
  double length_u = 0.0, length_v = 0.0, area = 0.0;
  const auto& ku = patch.knots_u;
  const auto& kv = patch.knots_v;
  for (int j = 0; j < kv.spans(); ++j)
    for (int i = 0; i < ku.spans(); ++i)
      for (int b = 0; b < 2; ++b)
        for (int a = 0; a < 2; ++a) {
          const double weight = ku.span_length(i) * kv.span_length(j);
          if (weight == 0.0) continue;
          const Vec2 p(ku.span_begin(i) + 0.5 * (1 + rule.point[a]) * ku.span_length(i),
                       kv.span_begin(j) + 0.5 * (1 + rule.point[b]) * kv.span_length(j));
          const SurfacePoint q = patch.evaluate(p);
          length_u += weight * q.u.norm(), length_v += weight * q.v.norm(), area += weight;
        }
  Patch scaled = patch;
  scaled.knots_u = ku.scaled(length_u / area);
  scaled.knots_v = kv.scaled(length_v / area);
  return scaled;
}

Patch plate(double size_x, double size_y, int elements_x, int elements_y, const Vec3& centre, const Quat& orientation) {
  Patch p{KnotVector::uniform(elements_x, size_x), KnotVector::uniform(elements_y, size_y), {}, {}};
  for (int j = 0; j < p.rows(); ++j)
    for (int i = 0; i < p.columns(); ++i)
      p.control_points.push_back(
          centre + orientation * Vec3(p.knots_u.greville(i) - 0.5 * size_x, p.knots_v.greville(j) - 0.5 * size_y, 0.0));
  p.weights.assign(p.control_points.size(), 1.0);
  return p;
}

}  // namespace sunder::shell
