#include "shell/solver/stepping/stable_step.h"

#include "shell/solver/forces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include <Eigen/Core>

#include "coupler/core/dense.h"

namespace sunder::shell {
namespace {

// Mean displacement of a control point in spacings: large against round-off, and small enough for linear forces.
constexpr double kProbe = 1e-7;

double noise(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1.0p-52 - 1.0; }

/// A shell during a measurement, with its previous state. Its velocities hold the mode.
struct Probed {
  Probed(const ShellRef& shell, bool as_if_free)
      : model(*shell.model),
        s(*shell.state),
        x(s.motion.x),
        v(s.motion.v),
        force(s.motion.force),
        inverse_mass(s.motion.inverse_mass) {
    for (std::size_t i = 0; i < s.motion.inverse_mass.size(); ++i)
      if (as_if_free && model.held[i] && s.motion.mass[i] > 0.0) s.motion.inverse_mass[i] = 1.0 / s.motion.mass[i];
  }
  void restore() {
    s.motion.x.swap(x), s.motion.v.swap(v), s.motion.force.swap(force), s.motion.inverse_mass.swap(inverse_mass);
  }

  const ShellModel& model;
  ShellState& s;
  std::vector<double> x, v, force, inverse_mass, at_rest;  // at_rest: forces at the present positions
};

// Whether K is symmetric, and forces linear for small probes: layers that yield go on yielding one way only, and what
// damage weakens is no gradient. Lanczos found a third of the stable step there.
bool elastic(const ShellState& s) { return !s.yields() && !s.weakens(); }

// Stable step [s] of central differences, with damping at velocities half a step earlier.
double step_of(const ShellMaterial& m, double omega) {
  const double damped = 0.5 * (m.stiffness_damping * omega + m.mass_damping / omega);
  return 2.0 / omega * (std::sqrt(1.0 + damped * damped) - damped);
}

/// Returns the largest eigenvalue of M^-1 K [1/s^2] by the method of Lanczos, in the scalar product of M. The
/// velocities hold the first guess. Lost orthogonality only copies eigenvalues that have converged, which does no harm.
template <class Forces>
double largest_eigenvalue(Probed& p, int iterations, const Forces& forces) {
  ShellState& s = p.s;
  p.at_rest = s.motion.force;
  const std::size_t stride = s.motion.inverse_mass.size();
  const double epsilon = kProbe * p.model.spacing * std::sqrt(static_cast<double>(p.model.control_points()));
  std::vector<double>&v = s.motion.v, before(v.size(), 0.0), next(v.size());
  Eigen::VectorXd diagonal(iterations), beside(iterations);
  const auto product = [&](const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
      if (s.motion.inverse_mass[i % stride] > 0.0) sum += a[i] * b[i] / s.motion.inverse_mass[i % stride];
    return sum;
  };
  for (std::size_t i = 0; i < v.size(); ++i)
    if (s.motion.inverse_mass[i % stride] == 0.0) v[i] = 0.0;
  double length = std::sqrt(product(v, v));
  int found = 0;
  for (; found < iterations && length > 0.0; ++found) {
    double norm = 0.0;
    for (double& a : v) a /= length, norm += a * a;
    norm = std::sqrt(norm);
    for (std::size_t i = 0; i < v.size(); ++i) s.motion.x[i] = p.x[i] + epsilon * (v[i] / norm);
    forces();
    for (std::size_t i = 0; i < v.size(); ++i)
      next[i] = -(s.motion.force[i] - p.at_rest[i]) * (norm / epsilon) * s.motion.inverse_mass[i % stride];
    diagonal[found] = product(v, next);
    for (std::size_t i = 0; i < v.size(); ++i)
      next[i] -= diagonal[found] * v[i] + (found > 0 ? beside[found - 1] * before[i] : 0.0);
    length = std::sqrt(product(next, next));
    beside[found] = length;
    std::swap(before, v), std::swap(v, next);
    if (!(length > 1e-6 * std::abs(diagonal[found]))) length = 0.0;  // the guess holds no further modes
  }
  if (found == 0) return 0.0;
  return tridiagonal_eigenvalues(diagonal.head(found), beside.head(found - 1))[found - 1];
}

/// Returns 2 / sqrt(lambda_max) [s] by power iteration. The velocities hold the first guess. `settle` takes back what
/// supports and joints do not let move.
template <class Forces, class Settle>
double iterate(std::vector<Probed>& shells, int iterations, const Forces& forces, const Settle& settle) {
  double epsilon = std::numeric_limits<double>::infinity(), points = 0.0, lambda = 0.0;
  for (Probed& p : shells) {
    p.at_rest = p.s.motion.force;
    epsilon = std::min(epsilon, kProbe * p.model.spacing), points += p.model.control_points();
  }
  epsilon *= std::sqrt(points);
  for (int it = 0; it < iterations; ++it) {
    settle();
    double norm = 0.0;
    for (Probed& p : shells) {
      const std::size_t stride = p.s.motion.inverse_mass.size();
      for (std::size_t i = 0; i < p.s.motion.v.size(); ++i) {
        if (p.s.motion.inverse_mass[i % stride] == 0.0) p.s.motion.v[i] = 0.0;
        norm += p.s.motion.v[i] * p.s.motion.v[i];
      }
    }
    norm = std::sqrt(norm);
    if (norm == 0.0) break;
    for (Probed& p : shells)
      for (std::size_t i = 0; i < p.x.size(); ++i) p.s.motion.x[i] = p.x[i] + epsilon * (p.s.motion.v[i] / norm);
    forces();
    for (Probed& p : shells) {
      const std::size_t stride = p.s.motion.inverse_mass.size();
      for (std::size_t i = 0; i < p.s.motion.v.size(); ++i)
        p.s.motion.v[i] = -(p.s.motion.force[i] - p.at_rest[i]) / epsilon * p.s.motion.inverse_mass[i % stride];
    }
    settle();
    double sum = 0.0;
    for (const Probed& p : shells)
      for (const double v : p.s.motion.v) sum += v * v;
    lambda = std::sqrt(sum);
  }
  if (lambda <= 0.0) return std::numeric_limits<double>::infinity();
  double step = std::numeric_limits<double>::infinity();
  for (const Probed& p : shells) step = std::min(step, step_of(p.model.material, std::sqrt(lambda)));
  return step;
}

}  // namespace

double stable_step(const ShellModel& m, ShellState& s, int iterations, int threads, bool as_if_free,
                   const std::vector<Vec2>& around) {
  const auto forces = [&] { compute_forces(m, s, false, 0.0, threads); };
  std::vector<Probed> shells{{ShellRef{&m, &s}, as_if_free}};
  forces();
  const std::size_t stride = m.tables.component_stride;
  std::vector<char> start(stride, around.empty());
  const Vec2 reach = kLargestSupport * Vec2(m.spacing_u, m.spacing_v);
  const RowTables& t = m.tables;
  const auto from = [&](const KnotVector& knots, double at) { return std::max(0, knots.span_of(at) - 1); };
  const auto to = [&](const KnotVector& knots, double at) {
    return std::min(knots.spans(), knots.span_of(at) + 1) + t.degree;
  };
  for (const Vec2& p : around) {
    const Vec2 low = p - reach, high = p + reach;
    for (int j = from(m.patch.knots_v, low.y()); j < std::min(t.rows, to(m.patch.knots_v, high.y())); ++j)
      for (int i = from(m.patch.knots_u, low.x()); i < std::min(t.columns, to(m.patch.knots_u, high.x())); ++i)
        if (((m.parameter[j * t.columns + i] - p).cwiseAbs().array() < reach.array()).all())
          start[t.slot(j * t.columns + i)] = 1;
  }
  std::mt19937_64 random(1);
  for (std::size_t i = 0; i < s.motion.v.size(); ++i) s.motion.v[i] = start[i % stride] ? noise(random) : 0.0;
  double step = std::numeric_limits<double>::infinity();
  if (elastic(s)) {
    const double lambda = largest_eigenvalue(shells[0], iterations, forces);
    if (lambda > 0.0) step = step_of(m.material, std::sqrt(lambda));
  } else {
    step = iterate(shells, 2 * iterations, forces, [] {});
  }
  shells[0].force = std::move(shells[0].at_rest);  // callers need the forces of the present positions
  shells[0].restore();
  return step;
}

namespace {

// Control points that a support holds along some axes only, of shells that are not taken as free: [shell][axis][slot].
// Empty where there are none.
std::vector<std::array<std::vector<int>, 3>> held_along_axes(const std::vector<ShellRef>& refs,
                                                             const std::vector<char>& as_if_free) {
  std::vector<std::array<std::vector<int>, 3>> out(refs.size());
  bool any = false;
  for (std::size_t k = 0; k < refs.size(); ++k)
    for (int d = 0; d < 3 && !as_if_free[k]; ++d)
      for (const int slot : refs[k].model->constraints.held[d])
        if (refs[k].model->held[slot] == 0) out[k][d].push_back(slot), any = true;
  if (!any) out.clear();
  return out;
}

}  // namespace

double stable_step(const std::vector<ShellRef>& refs, Stitching& stitching, int iterations, int threads,
                   const std::vector<char>& as_if_free) {
  const auto forces = [&] {
    for (const ShellRef& r : refs) compute_forces(*r.model, *r.state, false, 0.0, threads);
    stitching.move_forces(refs);
  };
  // A tie's force on an axis along which a support holds goes into the support, as constrain() has it in a run.
  const auto held = held_along_axes(refs, as_if_free);
  const auto settle = [&] {
    if (held.empty()) return;
    for (std::size_t k = 0; k < refs.size(); ++k) {
      std::vector<double>& v = refs[k].state->motion.v;
      for (int d = 0; d < 3; ++d)
        for (const int slot : held[k][d]) v[d * (v.size() / 3) + slot] = 0.0;
    }
    stitching.update_dependent_velocities(refs);
  };
  stitching.leave_supports_out(as_if_free);
  std::vector<Probed> shells;
  for (std::size_t k = 0; k < refs.size(); ++k) shells.emplace_back(refs[k], as_if_free[k] != 0);
  forces();
  std::mt19937_64 random(1);
  for (Probed& p : shells)
    for (double& v : p.s.motion.v) v = noise(random);
  stitching.align_velocities(refs);
  const double step = iterate(shells, iterations, forces, settle);
  stitching.leave_supports_out({});
  for (Probed& p : shells) p.restore();
  return step;
}

std::vector<double> joined_steps(const std::vector<ShellRef>& shells, Stitching& stitching,
                                 const std::vector<double>& alone, const std::vector<char>& as_if_free, int iterations,
                                 int threads) {
  const double together = stable_step(shells, stitching, iterations, threads, as_if_free);
  std::vector<double> out;
  for (std::size_t k = 0; k < shells.size(); ++k) out.push_back(std::max(as_if_free[k] ? alone[k] : 0.0, together));
  return out;
}

}  // namespace sunder::shell
