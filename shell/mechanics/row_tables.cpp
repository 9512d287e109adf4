#include "shell/mechanics/row_tables.h"

#include <algorithm>
#include <cmath>

#include "coupler/core/error.h"
#include "shell/geometry/quadrature.h"

namespace sunder::shell {

namespace {
constexpr double kWholeElement = 1e-9;  // share of an element's area that a loop may cut off and leave it whole
}

Layers gauss_layers(int count, double thickness) {
  const GaussRule& rule = gauss_rule(count);
  Layers layers;
  for (int l = 0; l < count; ++l) {
    layers.zeta.push_back(0.5 * thickness * rule.point[l]);
    layers.weight.push_back(0.5 * thickness * rule.weight[l]);
  }
  return layers;
}

Layers plies(int count, double thickness, double inner) {
  const double ply = 0.5 * (thickness - inner), middle = 0.5 * (inner + ply);
  const Layers one = gauss_layers(count, ply);
  Layers layers;
  for (const double side : {-1.0, 1.0})
    for (int l = 0; l < count; ++l) {
      layers.zeta.push_back(side * middle + one.zeta[l]);
      layers.weight.push_back(one.weight[l]);
    }
  return layers;
}

double half_height(const Layers& layers) {
  constexpr double kOfOneSheet = 1.0 + 1e-9;
  double half = 0.0, second = 0.0;
  for (std::size_t l = 0; l < layers.zeta.size(); ++l)
    half += 0.5 * layers.weight[l], second += layers.weight[l] * layers.zeta[l] * layers.zeta[l];
  if (second <= kOfOneSheet * (2.0 / 3.0) * half * half * half) return half;
  // two plies with a core between them: their second moment tells the height of their middles
  return std::sqrt(second / (2.0 * half) - half * half / 12.0) + 0.5 * half;
}

SectionFaces section_faces(const Layers& layers) {
  SectionFaces faces{half_height(layers), thickness_of(layers)};
  faces.squared = faces.thickness * faces.thickness;
  if (2.0 * faces.half <= faces.thickness) return faces;
  double second = 0.0;
  for (std::size_t l = 0; l < layers.zeta.size(); ++l) second += layers.weight[l] * layers.zeta[l] * layers.zeta[l];
  faces.squared = 6.0 * second / faces.half;
  return faces;
}

Layers linear_bending(double thickness) {
  Layers layers;
  layers.zeta = {0.0}, layers.weight = {thickness};
  layers.bending = thickness * thickness * thickness / 12.0;
  return layers;
}

void prestress(Layers& layers, double thickness, double surface_compression, const Elasticity& elasticity) {
  const double nu = 0.5 * elasticity.lambda / (elasticity.lambda + elasticity.mu);
  const double biaxial = elasticity.keeps_thickness() ? 2.0 * (elasticity.lambda + elasticity.mu)
                                                      : 2.0 * elasticity.mu * (1.0 + nu) / (1.0 - nu);
  const Sym2<double> unit{1.0, 1.0, 0.0};
  layers.growth.clear();
  for (const double z : layers.zeta) {
    const double wanted = surface_compression * (0.5 - 6.0 * z * z / (thickness * thickness));
    double growth = 1.0;
    double off = 0.0;
    for (int i = 0; i < 40; ++i) {  // the law is nearly linear: Newton with Hooke's slope
      const Sym2<double> grown{growth, growth, 0.0};
      off = plane_stress<double>(unit, grown, elasticity).s.c11 - wanted;
      growth += 2.0 * off / biaxial;
    }
    require(std::abs(off) <= 1e-6 * surface_compression,
            "a surface_compression of {:.4g} Pa: no strain makes that stress", surface_compression);
    layers.growth.push_back(growth);
  }
}

namespace {

int round_up(int n, int to) { return (n + to - 1) / to * to; }

// The basis of a span. A span without length is not summed, and gets arbitrary regular numbers.
Basis basis_at(const KnotVector& knots, int span, double point) {
  if (knots.span_length(span) == 0.0) return {{0.5, 0.5}, {-1.0, 1.0}, {}};
  return knots.basis(span, knots.span_begin(span) + 0.5 * (1.0 + point) * knots.span_length(span));
}

// Inverse of the sum of the weighted functions of a span, and the derivatives of the sum.
template <int kSupport>
void denominators(const Patch& patch, const Basis& bu, const Basis& bv, int span_u, int span_v, double* out) {
  double w[kRationalFields] = {};
  for (int j = 0; j < kSupport; ++j)
    for (int i = 0; i < kSupport; ++i) {
      const double weight = patch.weights[(span_v + j) * patch.columns() + span_u + i];
      w[0] += weight * bu.value[i] * bv.value[j], w[1] += weight * bu.first[i] * bv.value[j];
      w[2] += weight * bu.value[i] * bv.first[j], w[3] += weight * bu.second[i] * bv.value[j];
      w[4] += weight * bu.value[i] * bv.second[j], w[5] += weight * bu.first[i] * bv.first[j];
    }
  w[0] = 1.0 / w[0];
  std::copy(w, w + kRationalFields, out);
}

GaussPoint untrimmed_point(const Patch& patch, const RowTables& t, int block, int lane) {
  const GaussRule& rule = gauss_rule(t.gauss);
  const int row = block / t.gauss, a = block % t.gauss, f = row / t.gauss, b = row % t.gauss;
  const double lu = patch.knots_u.span_length(lane), lv = patch.knots_v.span_length(f);
  return {{gauss_parameter(patch.knots_u, rule, lane, a), gauss_parameter(patch.knots_v, rule, f, b)},
          0.25 * lu * lv * rule.weight[a] * rule.weight[b]};
}

}  // namespace

GaussPoint gauss_point(const Patch& patch, const RowTables& t, int block, int lane) {
  if (!t.trimmed.empty()) return t.trimmed[static_cast<std::size_t>(block) * t.lanes + lane];
  return untrimmed_point(patch, t, block, lane);
}

bool is_whole_element(const Patch& patch, const RowTables& t, int span_u, int span_v) {
  const int each = t.gauss * t.gauss;
  for (int block = span_v * each; block < (span_v + 1) * each; ++block) {
    const GaussPoint here = gauss_point(patch, t, block, span_u), rule = untrimmed_point(patch, t, block, span_u);
    if (here.weight != rule.weight || here.parameter != rule.parameter) return false;
  }
  return true;
}

namespace {

// The Gauss points that loops leave. Points of an element that a loop cuts stand where they integrate the part inside;
// those that this does not take have weight 0, as all have outside.
std::vector<GaussPoint> trimmed_points(const Patch& patch, const RowTables& t, const TrimLoops& trim) {
  std::vector<GaussPoint> out(static_cast<std::size_t>(t.blocks()) * t.lanes, {Vec2::Zero(), 0.0});
  const int each = t.gauss * t.gauss;
  for (int f = 0; f < t.spans_v; ++f)
    for (int e = 0; e < t.spans_u; ++e) {
      const Vec2 low(patch.knots_u.span_begin(e), patch.knots_v.span_begin(f));
      const Vec2 size(patch.knots_u.span_length(e), patch.knots_v.span_length(f));
      const auto at = [&](int k) -> GaussPoint& { return out[static_cast<std::size_t>(f * each + k) * t.lanes + e]; };
      for (int k = 0; k < each; ++k) at(k) = untrimmed_point(patch, t, f * each + k, e);
      if (size.prod() == 0.0) continue;
      const bool cut = trim.cuts(low, low + size);
      if (!cut && trim.contains(low + 0.5 * size)) continue;
      const std::vector<WeightedPlace> places =
          cut ? trim.places_in(low, low + size, each) : std::vector<WeightedPlace>();
      double area = 0.0;
      for (const WeightedPlace& p : places) area += p.area;
      if (std::abs(area - size.prod()) <= kWholeElement * size.prod()) continue;  // a loop runs along its border
      for (int k = 0; k < each; ++k) {
        at(k).weight = 0.0;
        if (k < static_cast<int>(places.size())) at(k) = {places[k].at, places[k].area};
      }
    }
  return out;
}

}  // namespace

RowTables make_row_tables(const Patch& patch, int gauss, const Layers& layers, const Elasticity& elasticity,
                          const std::string& field, const TrimLoops& trim, const ThicknessFactor& factor) {
  RowTables t;
  t.columns = patch.columns(), t.rows = patch.rows();
  t.spans_u = patch.knots_u.spans(), t.spans_v = patch.knots_v.spans();
  t.degree = patch.degree();
  t.gauss = gauss;
  t.lanes = round_up(t.spans_u, kLanes);
  t.stride = round_up(t.lanes + t.degree, 8);
  if (t.stride % 16 == 0) t.stride += 8;  // an odd number of 64-byte lines
  t.component_stride = t.stride * t.rows;
  t.rational = patch.rational() || factor;
  if (factor) t.thickness.assign(static_cast<std::size_t>(t.blocks()) * t.lanes, 1.0);
  t.layers = layers;
  t.elasticity = elasticity;

  if (!trim.empty()) t.trimmed = trimmed_points(patch, t, trim);
  const GaussRule& rule = gauss_rule(gauss);
  const int support = t.support();
  t.basis_u.assign(static_cast<std::size_t>(gauss) * 3 * support * t.lanes, 0.0);
  for (int a = 0; a < gauss; ++a)
    for (int e = 0; e < t.spans_u; ++e) {
      const Basis basis = basis_at(patch.knots_u, e, rule.point[a]);
      for (int k = 0; k < support; ++k) {
        t.basis_u[((a * 3 + 0) * support + k) * t.lanes + e] = basis.value[k];
        t.basis_u[((a * 3 + 1) * support + k) * t.lanes + e] = basis.first[k];
        t.basis_u[((a * 3 + 2) * support + k) * t.lanes + e] = basis.second[k];
      }
    }
  for (int f = 0; f < t.spans_v; ++f)
    for (int b = 0; b < gauss; ++b) {
      const Basis basis = basis_at(patch.knots_v, f, rule.point[b]);
      for (const auto* n : {&basis.value, &basis.first, &basis.second})
        t.basis_v.insert(t.basis_v.end(), n->begin(), n->begin() + support);
    }
  t.weight.assign(t.component_stride, 0.0);
  for (int i = 0; i < t.columns * t.rows; ++i) t.weight[t.slot(i)] = patch.weights[i];

  t.metric.assign(static_cast<std::size_t>(t.blocks()) * kMetricFields * t.lanes, 0.0);
  if (t.rational) t.denominator.assign(static_cast<std::size_t>(t.blocks()) * kRationalFields * t.lanes, 0.0);
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.lanes; ++e) {
      t.metric[t.at(q, kMetricFields, kA11, e)] = t.metric[t.at(q, kMetricFields, kA22, e)] = 1.0;
      if (t.rational) t.denominator[t.at(q, kRationalFields, kInvW, e)] = 1.0;
      if (e >= t.spans_u) continue;
      const GaussPoint g = gauss_point(patch, t, q, e);
      if (g.weight == 0.0) continue;
      const SurfacePoint s = patch.evaluate(g.parameter);
      const Vec3 cross = s.u.cross(s.v);
      const double jacobian = cross.norm();
      require(
          jacobian > 1e-10 * std::max(1e-300, s.u.norm() * s.v.norm()) && s.u.norm() > 0 && s.v.norm() > 0,
          "{}: the surface is degenerate at (u, v) = ({}, {}): its tangents are parallel or vanish; move the control "
          "points around it apart",
          field, g.parameter.x(), g.parameter.y());
      const Vec3 n = cross / jacobian;
      double* m = &t.metric[t.at(q, kMetricFields, 0, e)];
      m[kA11 * t.lanes] = s.u.dot(s.u), m[kA22 * t.lanes] = s.v.dot(s.v), m[kA12 * t.lanes] = s.u.dot(s.v);
      m[kB11 * t.lanes] = s.uu.dot(n), m[kB22 * t.lanes] = s.vv.dot(n), m[kB12 * t.lanes] = s.uv.dot(n);
      m[kArea * t.lanes] = jacobian * g.weight;
      if (factor) {
        const double f = factor(patch, g.parameter);
        require(f > 0.0 && std::isfinite(f), "{}: the thickness at (u, v) = ({}, {}) is {:.3g} times that of the shell",
                field, g.parameter.x(), g.parameter.y(), f);
        t.thickness[static_cast<std::size_t>(q) * t.lanes + e] = f;
        for (const int k : {kB11, kB22, kB12, kArea}) m[k * t.lanes] *= f;
      }
      if (t.rational) {
        const int row = q / gauss;
        const Basis bu = basis_at(patch.knots_u, e, rule.point[q % gauss]);
        const Basis bv = basis_at(patch.knots_v, row / gauss, rule.point[row % gauss]);
        double w[kRationalFields] = {};
        (t.degree == 2 ? denominators<3> : denominators<4>)(patch, bu, bv, e, row / gauss, w);
        for (int i = 0; i < kRationalFields; ++i) t.denominator[t.at(q, kRationalFields, i, e)] = w[i];
      }
    }
  return t;
}

}  // namespace sunder::shell
