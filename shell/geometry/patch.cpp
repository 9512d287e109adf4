#include "shell/geometry/patch.h"

#include <algorithm>
#include <cmath>

#include "coupler/core/error.h"
#include "shell/geometry/quadrature.h"

namespace sunder::shell {
namespace {

// Shape functions of one degree. The compiler fuses products with sums depending on array lengths and on inlining. A
// separate function for each degree keeps the last bits of a quadratic patch independent of the cubic code.
template <int kAcross>
struct Functions {
  int span_u = 0, span_v = 0;
  std::array<double, static_cast<std::size_t>(kAcross) * kAcross> value, u, v, uu, vv, uv;
};

template <int kAcross>
[[gnu::noinline]] Functions<kAcross> functions_at(const Patch& patch, const Vec2& p) {
  const KnotVector &knots_u = patch.knots_u, &knots_v = patch.knots_v;
  Functions<kAcross> s;
  s.span_u = knots_u.span_of(p.x());
  s.span_v = knots_v.span_of(p.y());
  const Basis bu = knots_u.basis(s.span_u, p.x()), bv = knots_v.basis(s.span_v, p.y());
  double w = 0, wu = 0, wv = 0, wuu = 0, wvv = 0, wuv = 0;  // the denominator and its derivatives
  for (int j = 0; j < kAcross; ++j)
    for (int i = 0; i < kAcross; ++i) {
      const int k = kAcross * j + i;
      const double weight = patch.weights[(s.span_v + j) * patch.columns() + s.span_u + i];
      w += s.value[k] = weight * bu.value[i] * bv.value[j];
      wu += s.u[k] = weight * bu.first[i] * bv.value[j];
      wv += s.v[k] = weight * bu.value[i] * bv.first[j];
      wuu += s.uu[k] = weight * bu.second[i] * bv.value[j];
      wvv += s.vv[k] = weight * bu.value[i] * bv.second[j];
      wuv += s.uv[k] = weight * bu.first[i] * bv.first[j];
    }
  // quotient rule; the highest derivatives are computed first from unchanged lower ones
  for (int k = 0; k < kAcross * kAcross; ++k) {
    const double r = s.value[k] / w;
    const double ru = (s.u[k] - wu * r) / w, rv = (s.v[k] - wv * r) / w;
    s.uu[k] = (s.uu[k] - 2.0 * wu * ru - wuu * r) / w;
    s.vv[k] = (s.vv[k] - 2.0 * wv * rv - wvv * r) / w;
    s.uv[k] = (s.uv[k] - wu * rv - wv * ru - wuv * r) / w;
    s.value[k] = r, s.u[k] = ru, s.v[k] = rv;
  }
  return s;
}

template <int kAcross>
ShapeFunctions widened(const Functions<kAcross>& s) {
  ShapeFunctions out;
  out.span_u = s.span_u, out.span_v = s.span_v, out.across = kAcross;
  const auto copy = [](const auto& from, auto& to) { std::copy(from.begin(), from.end(), to.begin()); };
  copy(s.value, out.value), copy(s.u, out.u), copy(s.v, out.v);
  copy(s.uu, out.uu), copy(s.vv, out.vv), copy(s.uv, out.uv);
  return out;
}

template <int kAcross>
SurfacePoint point_at(const Patch& patch, const Vec2& p, const std::vector<Vec3>& net) {
  const Functions<kAcross> s = functions_at<kAcross>(patch, p);
  SurfacePoint q{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  for (int k = 0; k < kAcross * kAcross; ++k) {
    const Vec3& x = net[(s.span_v + k / kAcross) * patch.columns() + s.span_u + k % kAcross];
    q.x += s.value[k] * x, q.u += s.u[k] * x, q.v += s.v[k] * x;
    q.uu += s.uu[k] * x, q.vv += s.vv[k] * x, q.uv += s.uv[k] * x;
  }
  return q;
}

}  // namespace

bool Patch::rational() const {
  for (const double w : weights)
    if (w != weights.front()) return true;
  return false;
}

ShapeFunctions Patch::shape_functions(const Vec2& p) const {
  return degree() == 2 ? widened(functions_at<3>(*this, p)) : widened(functions_at<4>(*this, p));
}

SurfacePoint Patch::evaluate(const Vec2& p, const std::vector<Vec3>& net) const {
  return degree() == 2 ? point_at<3>(*this, p, net) : point_at<4>(*this, p, net);
}

void validate(const Patch& patch, const std::string& field) {
  const std::size_t expected = static_cast<std::size_t>(patch.columns()) * patch.rows();
  require(patch.knots_v.degree() == patch.degree(), "{}: degree {} along u and {} along v; give both the same", field,
          patch.degree(), patch.knots_v.degree());
  require(
      patch.control_points.size() == expected,
      "{}.control_points: {} points, but the knots ask for {} x {} = {}; a direction of degree {} has {} knots more "
      "than control points",
      field, patch.control_points.size(), patch.columns(), patch.rows(), expected, patch.degree(), patch.degree() + 1);
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

Patch plate(double size_x, double size_y, int elements_x, int elements_y, const Vec3& centre, const Quat& orientation,
            int degree) {
  Patch p{KnotVector::uniform(elements_x, size_x, degree), KnotVector::uniform(elements_y, size_y, degree), {}, {}};
  for (int j = 0; j < p.rows(); ++j)
    for (int i = 0; i < p.columns(); ++i)
      p.control_points.push_back(
          centre + orientation * Vec3(p.knots_u.greville(i) - 0.5 * size_x, p.knots_v.greville(j) - 0.5 * size_y, 0.0));
  p.weights.assign(p.control_points.size(), 1.0);
  return p;
}

}  // namespace sunder::shell
