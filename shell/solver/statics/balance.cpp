#include "shell/solver/statics/balance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "shell/solver/forces.h"

namespace sunder::shell {
namespace {

constexpr double kUnloadedStrain = 1e-7;  // whose force is the scale of a residual where there is no load

// Returns row sums of the stiffness, bounded by norms of the shape functions' derivatives [N/m]. As masses they give
// every control point a similar step, however small or distorted its elements are.
std::vector<double> fictitious_masses(const ShellModel& m, const ShellState& s) {
  const RowTables& t = m.tables;
  const double e = m.material.youngs_modulus / (1.0 - m.material.poisson_ratio * m.material.poisson_ratio);
  const double membrane = e * m.thickness, bending = e * std::pow(m.thickness, 3) / 12.0;
  std::vector<double> mass(t.component_stride, 0.0);
  const auto add = [&](const std::vector<GatheredFunction>& n, const Sym2<double>& a, double area) {
    const double det = determinant(a);
    const auto dot = [&](double pu, double pv, double qu, double qv) {
      return (a.c22 * pu * qu + a.c11 * pv * qv - a.c12 * (pu * qv + pv * qu)) / det;
    };
    double first = 0.0, second = 0.0;
    std::vector<std::pair<double, double>> norms;
    for (const GatheredFunction& f : n) {
      const double g = std::sqrt(std::max(0.0, dot(f.n[1], f.n[2], f.n[1], f.n[2])));
      const double uu = f.n[3] * a.c22 / det, vv = f.n[4] * a.c11 / det;
      const double h = std::sqrt(uu * uu + vv * vv + 2.0 * f.n[5] * f.n[5] / det);
      norms.emplace_back(g, h);
      first += g, second += h;
    }
    for (std::size_t k = 0; k < n.size(); ++k)
      mass[n[k].slot] += area * (membrane * norms[k].first * first + bending * norms[k].second * second);
  };
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e) {
      const double* metric = &s.cracked.tables.metric[t.at(q, kMetricFields, 0, e)];
      if (metric[kArea * t.lanes] == 0.0) continue;
      add(patch_functions(m.patch, gauss_point(m.patch, t, q, e).parameter, t.stride),
          {metric[kA11 * t.lanes], metric[kA22 * t.lanes], metric[kA12 * t.lanes]}, metric[kArea * t.lanes]);
    }
  for (const GatheredPoint& g : s.cracked.gathered)
    if (g.kind != PointKind::kDead && !g.in_rows) add(g.functions, g.metric.a, g.area);
  return mass;
}

double norm_of(const std::vector<double>& f, const std::vector<double>& inverse, bool free) {
  double sum = 0.0;
  for (std::size_t i = 0; i < f.size(); ++i)
    if ((inverse[i] > 0.0) == free) sum += f[i] * f[i];
  return std::sqrt(sum);
}

}  // namespace

Balance::Balance(const ShellModel& m, ShellState& s, const Vec3& gravity, int threads)
    : mass(fictitious_masses(m, s)), m_(m), s_(s), threads_(threads), start_(s.motion.x) {
  const std::size_t stride = m.tables.component_stride;
  weight_.assign(3 * stride, 0.0);
  inverse.assign(3 * stride, 0.0);
  for (int d = 0; d < 3; ++d) {
    for (std::size_t i = 0; i < stride; ++i) {
      weight_[d * stride + i] = s.motion.mass[i] * gravity[d];
      if (mass[i] > 0.0 && !s.motion.detached[i]) inverse[d * stride + i] = 1.0 / mass[i];
    }
    for (const int slot : m.constraints.held[d]) inverse[d * stride + slot] = 0.0;
    for (const auto& driven : m.constraints.driven)
      for (const int slot : driven.slots[d]) inverse[d * stride + slot] = 0.0;
    for (const auto& group : m.constraints.tied[d]) {
      double sum = 0.0;
      for (const int slot : group) sum += mass[slot];
      for (const int slot : group) inverse[d * stride + slot] = 1.0 / sum;
    }
  }
}

void Balance::go_to(double share) {
  if (share < 1.0 && unbalanced_.empty()) {
    const std::vector<double> x = std::exchange(s_.motion.x, start_);
    share_ = 1.0;
    compute();
    unbalanced_ = s_.motion.force;
    if (m_.loads.rotate_with_surface()) external_ = s_.motion.external;
    s_.motion.x = x;
  }
  share_ = share;
  const std::size_t stride = m_.tables.component_stride;
  for (const auto& driven : m_.constraints.driven) {
    const Vec3 u = driven.displacement(s_.motion.time);
    for (int d = 0; d < 3; ++d)
      for (const int slot : driven.slots[d]) {
        const std::size_t k = d * stride + slot;
        const double target = m_.rest[k] + u[d];
        s_.motion.x[k] = share == 1.0 ? target : start_[k] + share * (target - start_[k]);
      }
  }
}

void Balance::compute() {
  compute_forces(m_, s_, false, 0.0, threads_);
  for (std::size_t i = 0; i < weight_.size(); ++i) s_.motion.force[i] += weight_[i];
  if (share_ == 1.0) return;
  for (std::size_t i = 0; i < weight_.size(); ++i) s_.motion.force[i] -= (1.0 - share_) * unbalanced_[i];
  for (std::size_t i = 0; i < external_.size(); ++i)
    s_.motion.force[i] -= (1.0 - share_) * (s_.motion.external[i] - external_[i]);
}

void Balance::gather(std::vector<double>& f) const {
  const std::size_t stride = m_.tables.component_stride;
  for (int d = 0; d < 3; ++d)
    for (const auto& group : m_.constraints.tied[d]) {
      double sum = 0.0;
      for (const int slot : group) sum += f[d * stride + slot];
      for (const int slot : group) f[d * stride + slot] = sum;
    }
}

double Balance::scale() const {
  double outside = 0.0;
  for (std::size_t i = 0; i < weight_.size(); ++i)
    outside += std::pow(weight_[i] + (s_.motion.external.empty() ? 0.0 : s_.motion.external[i]), 2);
  const double given = std::sqrt(outside), held = norm_of(s_.motion.force, inverse, false);
  // Without a load nothing but the stiffness tells which force is small.
  const double least = given > 0.0 ? 0.0
                                   : kUnloadedStrain * m_.material.youngs_modulus * m_.thickness * m_.spacing *
                                         std::sqrt(static_cast<double>(m_.control_points()));
  return std::isnan(held) ? held : std::max({given, held, least});
}

double Balance::residual(std::vector<double>& summed) const {
  summed = s_.motion.force;
  gather(summed);
  const double all = scale();
  return all == 0.0 ? 0.0 : norm_of(summed, inverse, true) / all;
}

double Balance::round_off() {
  const std::vector<double> x = s_.motion.x, before = s_.motion.force;
  const double all = scale();
  std::mt19937 random(1);
  for (double& at : s_.motion.x)
    at *= 1.0 + ((random() & 1) != 0 ? 1.0 : -1.0) * std::numeric_limits<double>::epsilon();
  compute();
  std::vector<double> change(before.size());
  for (std::size_t i = 0; i < change.size(); ++i) change[i] = s_.motion.force[i] - before[i];
  gather(change);
  s_.motion.x = x, s_.motion.force = before;
  return all > 0.0 ? norm_of(change, inverse, true) / all : 0.0;
}

double Balance::work_from(const std::vector<double>& start) const {
  double done = 0.0;
  for (std::size_t i = 0; i < weight_.size(); ++i)
    done += (weight_[i] + (s_.motion.external.empty() ? 0.0 : s_.motion.external[i])) * (s_.motion.x[i] - start[i]);
  return done;
}

}  // namespace sunder::shell
