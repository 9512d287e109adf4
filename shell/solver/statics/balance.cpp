#include "shell/solver/statics/balance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "shell/solver/forces.h"

namespace sunder::shell {
namespace {

constexpr double kRidge = 1e-13;          // of the diagonal: constraints may say nearly the same
constexpr int kClosings = 4;              // Newton steps that bring constraints back
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
      std::vector<GatheredFunction> n = patch_functions(m.patch, gauss_point(m.patch, t, q, e).parameter, t.stride);
      thicken(n, t.thickness_factor(q, e));
      add(n, {metric[kA11 * t.lanes], metric[kA22 * t.lanes], metric[kA12 * t.lanes]}, metric[kArea * t.lanes]);
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

Balance::Balance(const JoinedShells& joined, int threads) : joined_(joined), degrees_(joined), threads_(threads) {
  for (std::size_t k = 0; k < joined.shells.size(); ++k) {
    const ShellModel& m = *joined.shells[k].model;
    const ShellState& s = *joined.shells[k].state;
    const std::size_t stride = m.tables.component_stride, first = degrees_.first(k);
    x.insert(x.end(), s.motion.x.begin(), s.motion.x.end());
    const std::vector<double> own = fictitious_masses(m, s);
    for (int d = 0; d < 3; ++d) {
      mass.insert(mass.end(), own.begin(), own.end());
      for (std::size_t i = 0; i < stride; ++i) weight_.push_back(s.motion.mass[i] * joined.gravity[k][d]);
    }
    inverse.resize(first + 3 * stride, 0.0);
  }
  degrees_.hand_over_mass(mass);
  degrees_.hand_over_mass(weight_);
  for (std::size_t k = 0; k < joined.shells.size(); ++k) {
    const ShellModel& m = *joined.shells[k].model;
    const ShellState& s = *joined.shells[k].state;
    const std::size_t stride = m.tables.component_stride;
    for (int d = 0; d < 3; ++d) {
      const std::size_t at = degrees_.first(k) + d * stride;
      for (std::size_t i = 0; i < stride; ++i)
        if (mass[at + i] > 0.0 && !s.motion.detached[i] && !degrees_.dependent(at + i))
          inverse[at + i] = 1.0 / mass[at + i];
      for (const int slot : m.constraints.held[d]) inverse[at + slot] = 0.0;
      for (const auto& driven : m.constraints.driven)
        for (const int slot : driven.slots[d]) inverse[at + slot] = 0.0;
      for (const auto& group : m.constraints.tied[d]) {
        double sum = 0.0;
        for (const int slot : group) sum += mass[at + slot];
        for (const int slot : group) inverse[at + slot] = degrees_.dependent(at + slot) ? 0.0 : 1.0 / sum;
      }
    }
  }
  start_ = x, force.assign(x.size(), 0.0);
  if (degrees_.constrained()) inverse_ = degrees_.reduced(inverse);
}

bool Balance::rotates() const {
  return std::any_of(joined_.shells.begin(), joined_.shells.end(),
                     [](const ShellRef& r) { return r.model->loads.rotate_with_surface(); });
}

void Balance::go_to(double share) {
  if (share < 1.0 && unbalanced_.empty()) {
    const std::vector<double> here = std::exchange(x, start_);
    share_ = 1.0;
    compute();
    unbalanced_ = force;
    if (rotates()) external_ = loads_;
    x = here;
  }
  share_ = share;
  for (std::size_t k = 0; k < joined_.shells.size(); ++k) {
    const ShellModel& m = *joined_.shells[k].model;
    const std::size_t stride = m.tables.component_stride;
    for (const auto& driven : m.constraints.driven) {
      const Vec3 u = driven.displacement(joined_.shells[k].state->motion.time);
      for (int d = 0; d < 3; ++d)
        for (const int slot : driven.slots[d]) {
          const std::size_t own = d * stride + slot, at = degrees_.first(k) + own;
          const double target = m.rest[own] + u[d];
          if (!degrees_.dependent(at)) x[at] = share == 1.0 ? target : start_[at] + share * (target - start_[at]);
        }
    }
  }
  if (!joined_.stitching) return;
  std::vector<double> u(x.size());  // driven control points move dependent ones
  for (std::size_t i = 0; i < u.size(); ++i) u[i] = x[i] - start_[i];
  degrees_.follow(u);
  for (std::size_t i = 0; i < u.size(); ++i)
    if (degrees_.dependent(i)) x[i] = start_[i] + u[i];
}

void Balance::compute(std::size_t k) {
  const ShellRef& r = joined_.shells[k];
  const bool alone = joined_.shells.size() == 1;
  compute_forces(*r.model, *r.state, false, 0.0, alone ? threads_ : 1);
  std::vector<double>& f = r.state->motion.force;
  const std::size_t first = degrees_.first(k);
  for (std::size_t i = 0; i < f.size(); ++i) f[i] += weight_[first + i];
  if (share_ == 1.0) return;
  for (std::size_t i = 0; i < f.size(); ++i) f[i] -= (1.0 - share_) * unbalanced_[first + i];
  if (external_.empty() || r.state->motion.external.empty()) return;
  for (std::size_t i = 0; i < f.size(); ++i)
    f[i] -= (1.0 - share_) * (r.state->motion.external[i] - external_[first + i]);
}

void Balance::compute() {
  const auto shells = static_cast<int>(joined_.shells.size());
  for (int k = 0; k < shells; ++k) {
    std::vector<double>& own = joined_.shells[k].state->motion.x;
    std::copy_n(x.begin() + static_cast<std::ptrdiff_t>(degrees_.first(k)), own.size(), own.begin());
  }
  each_shell([this](std::size_t k) { compute(k); });
  for (int k = 0; k < shells; ++k) {
    const Motion& motion = joined_.shells[k].state->motion;
    const auto first = static_cast<std::ptrdiff_t>(degrees_.first(k));
    std::copy(motion.force.begin(), motion.force.end(), force.begin() + first);
    if (motion.external.empty()) continue;
    loads_.resize(x.size(), 0.0);
    std::copy(motion.external.begin(), motion.external.end(), loads_.begin() + first);
  }
}

void Balance::gather(std::vector<double>& f) const {
  degrees_.hand_over(f);
  for (std::size_t k = 0; k < joined_.shells.size(); ++k) {
    const ShellModel& m = *joined_.shells[k].model;
    const std::size_t stride = m.tables.component_stride;
    for (int d = 0; d < 3; ++d)
      for (const auto& group : m.constraints.tied[d]) {
        const std::size_t at = degrees_.first(k) + d * stride;
        double sum = 0.0;
        for (const int slot : group) sum += f[at + slot];
        for (const int slot : group) f[at + slot] = sum;
      }
  }
}

// Multipliers of forces that make accelerations by the inverse masses keep the constraints: (G W G^T) m = G W f. That
// of a constraint without a gradient, whose direction is held, is 0. Not a number where positions are not.
Eigen::VectorXd Balance::multipliers_of(const Eigen::VectorXd& f) {
  gradients_ = degrees_.gradients(x);
  const Eigen::SparseMatrix<double> weighted = gradients_ * inverse_.asDiagonal();
  Eigen::SparseMatrix<double> matrix = weighted * gradients_.transpose();
  const double most = matrix.diagonal().maxCoeff();
  for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
    double& own = matrix.coeffRef(r, r);
    own = own == 0.0 ? 1.0 : own + kRidge * most;
  }
  factors_.compute(matrix);
  if (factors_.info() != Eigen::Success)
    return Eigen::VectorXd::Constant(matrix.rows(), std::numeric_limits<double>::quiet_NaN());
  Eigen::VectorXd out = factors_.solve(weighted * f);
  out += factors_.solve(weighted * (f - gradients_.transpose() * out));  // takes away what the ridge leaves
  return out;
}

void Balance::take_off(std::vector<double>& f) {
  if (!degrees_.constrained()) return;
  Eigen::VectorXd own = degrees_.reduced(f);
  multipliers_ = multipliers_of(own);
  own -= gradients_.transpose() * multipliers_;
  for (std::size_t i = 0; i < f.size(); ++i)
    if (const int n = degrees_.number()[i]; n >= 0) f[i] = own[n];
}

void Balance::close() {
  if (!degrees_.constrained()) return;
  for (int k = 0; k < kClosings; ++k) {
    multipliers_of(Eigen::VectorXd::Zero(degrees_.count()));
    if (factors_.info() != Eigen::Success) return;
    const Eigen::VectorXd impulses = factors_.solve(degrees_.violations(x));
    const std::vector<double> u = degrees_.expanded(-inverse_.cwiseProduct(gradients_.transpose() * impulses));
    for (std::size_t i = 0; i < u.size(); ++i) x[i] += u[i];
  }
}

double Balance::open() const { return degrees_.constrained() ? degrees_.violations(x).cwiseAbs().maxCoeff() : 0.0; }

double Balance::scale() const {
  double outside = 0.0;
  for (std::size_t i = 0; i < weight_.size(); ++i) outside += std::pow(weight_[i] + external(i), 2);
  std::vector<double> handed;  // dependent control points bear nothing
  if (joined_.stitching) handed = force, degrees_.hand_over(handed);
  const double given = std::sqrt(outside), held = norm_of(joined_.stitching ? handed : force, inverse, false);
  // Without a load nothing but the stiffness tells which force is small.
  double least = 0.0;
  if (given <= 0.0)
    for (const ShellRef& r : joined_.shells)
      least = std::max(least, kUnloadedStrain * r.model->material.youngs_modulus * r.model->thickness *
                                  r.model->spacing * std::sqrt(static_cast<double>(r.model->control_points())));
  return std::isnan(held) ? held : std::max({given, held, least});
}

double Balance::residual(std::vector<double>& summed) {
  summed = force;
  gather(summed);
  take_off(summed);
  const double all = scale();
  return all == 0.0 ? 0.0 : norm_of(summed, inverse, true) / all;
}

double Balance::round_off() {
  const std::vector<double> here = x, before = force;
  const double all = scale();
  std::mt19937 random(1);
  for (double& at : x) at *= 1.0 + ((random() & 1) != 0 ? 1.0 : -1.0) * std::numeric_limits<double>::epsilon();
  compute();
  std::vector<double> change(before.size());
  for (std::size_t i = 0; i < change.size(); ++i) change[i] = force[i] - before[i];
  gather(change);
  x = here, force = before;
  const Eigen::VectorXd multipliers = multipliers_;
  take_off(change);
  multipliers_ = multipliers;
  return all > 0.0 ? norm_of(change, inverse, true) / all : 0.0;
}

double Balance::work_on(const std::vector<double>& step) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < step.size(); ++i) sum += force[i] * step[i];
  if (degrees_.constrained()) sum -= multipliers_.dot(degrees_.gradients(x) * degrees_.reduced(step));
  return sum;
}

double Balance::work_from(const std::vector<double>& start) const {
  double done = 0.0;
  for (std::size_t i = 0; i < weight_.size(); ++i) done += (weight_[i] + external(i)) * (x[i] - start[i]);
  return done;
}

}  // namespace sunder::shell
