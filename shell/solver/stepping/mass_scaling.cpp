#include "shell/solver/stepping/mass_scaling.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include <Eigen/Dense>

#include "coupler/core/dense.h"

namespace sunder::shell {
namespace {

constexpr double kSameElement =
    1e-6;  // difference of two numbers of elements that count as alike, in elements' lengths

/// Stiffness of the section against strain of the middle surface [N/m] and against curvature [N m], plane and
/// isotropic.
struct SectionStiffness {
  Eigen::Matrix3d membrane = Eigen::Matrix3d::Zero(), bending = Eigen::Matrix3d::Zero();

  void add(const Layers& layers, const Elasticity& e) {
    const double lambda = e.keeps_thickness() ? e.lambda : 2.0 * e.lambda * e.mu / (e.lambda + 2.0 * e.mu);
    Eigen::Matrix3d c;
    c << lambda + 2.0 * e.mu, lambda, 0.0, lambda, lambda + 2.0 * e.mu, 0.0, 0.0, 0.0, e.mu;
    double second = layers.bending;
    for (std::size_t k = 0; k < layers.zeta.size(); ++k) second += layers.weight[k] * layers.zeta[k] * layers.zeta[k];
    membrane += thickness_of(layers) * c, bending += second * c;
  }
};

/// A Gauss point at rest, in its own orthonormal axes 1, 2 and normal.
struct RestPoint {
  std::vector<GatheredFunction> functions;
  Vec3 a1 = Vec3::Zero(), a2 = Vec3::Zero(), uu = Vec3::Zero(), vv = Vec3::Zero(), uv = Vec3::Zero();
  Vec3 e1, e2, normal;
  double area = 0.0;    // [m^2]
  double factor = 1.0;  // of the thickness

  RestPoint(const ShellModel& m, int block, int lane) {
    const RowTables& t = m.tables;
    shell_functions(m, block, lane, functions);
    factor = t.thickness_factor(block, lane);
    area = t.metric[t.at(block, kMetricFields, kArea, lane)] / factor;
    for (const GatheredFunction& f : functions) {
      const Vec3 x(m.rest[f.slot], m.rest[t.component_stride + f.slot], m.rest[2 * t.component_stride + f.slot]);
      a1 += f.n[1] * x, a2 += f.n[2] * x, uu += f.n[3] * x, vv += f.n[4] * x, uv += f.n[5] * x;
    }
    normal = a1.cross(a2).normalized(), e1 = a1.normalized(), e2 = normal.cross(e1);
  }
  /// Derivatives of the surface by parameters, as rows, over axes 1 and 2.
  Eigen::Matrix2d jacobian() const {
    Eigen::Matrix2d j;
    j << a1.dot(e1), a1.dot(e2), a2.dot(e1), a2.dot(e2);
    return j;
  }
};

// Numbers that are the same for elements that differ by a rigid motion alone, in units of the element's length.
std::vector<std::int64_t> key_of(const std::vector<RestPoint>& points, double length) {
  std::vector<std::int64_t> key;
  const auto add = [&](double v) { key.push_back(std::llround(v / kSameElement)); };
  add(std::log(length));
  for (const RestPoint& p : points) {
    add(p.area / (length * length)), add(p.factor);
    for (const Vec3* first : {&p.a1, &p.a2}) {
      add(first->dot(p.e1)), add(first->dot(p.e2));
      for (const Vec3* second : {&p.uu, &p.vv, &p.uv}) add(length * second->dot(*first));
    }
    for (const Vec3* second : {&p.uu, &p.vv, &p.uv}) add(length * second->dot(p.normal));
    for (const GatheredFunction& f : p.functions) {
      add(f.n[0]), add(f.n[1] * length), add(f.n[2] * length);
      for (int k = 3; k < 6; ++k) add(f.n[k] * length * length);
    }
  }
  return key;
}

double largest_eigenvalue_of(const ShellModel& m, const SectionStiffness& section,
                             const std::vector<RestPoint>& points) {
  std::vector<int> slots;
  for (const RestPoint& p : points)
    for (const GatheredFunction& f : p.functions) slots.push_back(f.slot);
  std::sort(slots.begin(), slots.end());
  slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
  const Eigen::Index size = 3 * static_cast<Eigen::Index>(slots.size());
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(size);
  Eigen::MatrixXd strain, curvature;
  for (const RestPoint& p : points) {
    const Eigen::Matrix2d to_axes = p.jacobian().inverse();
    // Christoffel symbols by products with the dual basis; b_ij = N;ij n . u
    const Eigen::Matrix2d metric = p.jacobian() * p.jacobian().transpose();
    const auto symbols = [&](const Vec3& second) -> Eigen::Vector2d {
      return metric.inverse() * Eigen::Vector2d(second.dot(p.a1), second.dot(p.a2));
    };
    const Eigen::Vector2d g11 = symbols(p.uu), g22 = symbols(p.vv), g12 = symbols(p.uv);
    strain.setZero(3, size), curvature.setZero(3, size);
    for (const GatheredFunction& f : p.functions) {
      const Eigen::Index at =
          3 * static_cast<Eigen::Index>(std::lower_bound(slots.begin(), slots.end(), f.slot) - slots.begin());
      const Eigen::Vector2d by_parameters(f.n[1], f.n[2]), d = to_axes * by_parameters;
      Eigen::Matrix2d covariant;
      covariant(0, 0) = f.n[3] - g11.dot(by_parameters), covariant(1, 1) = f.n[4] - g22.dot(by_parameters);
      covariant(0, 1) = covariant(1, 0) = f.n[5] - g12.dot(by_parameters);
      const Eigen::Matrix2d second = to_axes * covariant * to_axes.transpose();
      strain.block<1, 3>(0, at) += d[0] * p.e1.transpose();
      strain.block<1, 3>(1, at) += d[1] * p.e2.transpose();
      strain.block<1, 3>(2, at) += d[1] * p.e1.transpose() + d[0] * p.e2.transpose();
      curvature.block<1, 3>(0, at) += second(0, 0) * p.normal.transpose();
      curvature.block<1, 3>(1, at) += second(1, 1) * p.normal.transpose();
      curvature.block<1, 3>(2, at) += 2.0 * second(0, 1) * p.normal.transpose();
      // a function that trims continue may be negative
      mass.segment<3>(at).array() += m.material.density * m.thickness * p.factor * p.area * std::abs(f.n[0]);
    }
    stiffness += p.area * (p.factor * strain.transpose() * section.membrane * strain +
                           std::pow(p.factor, 3) * curvature.transpose() * section.bending * curvature);
  }
  const Eigen::VectorXd root = mass.cwiseSqrt().cwiseInverse();
  stiffness = root.asDiagonal() * stiffness * root.asDiagonal();
  return eigenvalues(stiffness).maxCoeff();
}

// Calls f(element, block) with each Gauss point that material has.
template <class F>
void each_point(const RowTables& t, F&& f) {
  for (int block = 0; block < t.blocks(); ++block)
    for (int lane = 0; lane < t.spans_u; ++lane)
      if (t.metric[t.at(block, kMetricFields, kArea, lane)] != 0.0)
        f(static_cast<std::size_t>(block / (t.gauss * t.gauss)) * t.spans_u + lane, block, lane);
}

}  // namespace

const MassScaling::Lowered& MassScaling::worst() const {
  return *std::max_element(modes.begin(), modes.end(),
                           [](const Lowered& a, const Lowered& b) { return a.error() < b.error(); });
}

std::vector<double> element_eigenvalues(const ShellModel& m) {
  const RowTables& t = m.tables;
  SectionStiffness section;
  section.add(t.layers, t.elasticity);
  if (m.laminated()) section.add(m.interlayer.layers, m.interlayer.elasticity);
  std::vector<std::vector<RestPoint>> points(static_cast<std::size_t>(t.spans_u) * t.spans_v);
  each_point(t, [&](std::size_t element, int block, int lane) { points[element].emplace_back(m, block, lane); });
  std::map<std::vector<std::int64_t>, double> known;
  std::vector<double> out(points.size(), 0.0);
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (points[k].empty()) continue;
    double area = 0.0;
    for (const RestPoint& p : points[k]) area += p.area;
    const auto [place, fresh] = known.try_emplace(key_of(points[k], std::sqrt(area)), 0.0);
    if (fresh) place->second = largest_eigenvalue_of(m, section, points[k]);
    out[k] = place->second;
  }
  return out;
}

double add_mass(ShellModel& m, const std::vector<double>& own, const std::vector<double>& eigenvalues, double limit) {
  const RowTables& t = m.tables;
  std::vector<double> added(own.size(), 0.0);
  std::vector<GatheredFunction> functions;
  double whole = 0.0, positive = 0.0;
  each_point(t, [&](std::size_t element, int block, int lane) {
    const double factor = eigenvalues[element] / limit;
    if (factor <= 1.0) return;
    const double area = t.metric[t.at(block, kMetricFields, kArea, lane)];  // times the factor of the thickness
    const double mass = (factor - 1.0) * m.material.density * m.thickness * area;
    shell_functions(m, block, lane, functions);
    for (const GatheredFunction& f : functions) added[f.slot] += mass * f.n[0];
    whole += mass;
  });
  // Beside trims functions may be negative; no control point may get lighter, or a frequency could rise.
  for (double& a : added) a = std::max(a, 0.0), positive += a;
  m.mass = own, m.mass_factor_of_slot.assign(own.size(), 1.0);
  for (std::size_t i = 0; i < own.size() && whole > 0.0; ++i) {
    if (own[i] <= 0.0 || added[i] == 0.0) continue;
    m.mass[i] += added[i] * whole / positive;
    m.mass_factor_of_slot[i] = m.mass[i] / own[i];
  }
  m.largest_mobility = largest_mobility(m);
  return whole;
}

}  // namespace sunder::shell
