#include "shell/solver/statics/relaxation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "shell/solver/forces.h"
#include "shell/solver/statics/newton.h"

namespace sunder::shell {
namespace {

constexpr double kStep = 0.9;       // share of the stable step
constexpr int kMeasureEvery = 400;  // steps between two measurements of the stable step
constexpr int kFirstIterations = 150,
              kLaterIterations = 16;  // of the first measurement; of the later ones, which start from its mode
constexpr int kCheckEvery = 50;       // steps between two checks of the residual
constexpr double kLongestStep = 0.1;  // longest Newton step, as a share of the shell's size
constexpr int kPatience = 5;          // Newton steps without progress
constexpr double kRoundOff = 1e-3;    // a residual below this that does not fall is round-off
constexpr int kMostHalvings = 6;      // of a Newton step
constexpr double kFallen = 0.8;       // a step is accepted when the residual's work on it has fallen to this share
constexpr double kWorse = 2.0;        // multiple of the least remaining work at which Newton's search returns to it
constexpr double kMargin = 1.1;       // power iteration approaches the eigenvalue from below

// Returns row sums of the stiffness, bounded by norms of the shape functions' derivatives [N/m]. As masses they give
// every control point a similar step, however small or distorted its elements are.
std::vector<double> fictitious_masses(const ShellModel& m, const ShellState& s) {
  const RowTables& t = m.tables;
  const double e = m.material.youngs_modulus / (1.0 - m.material.poisson_ratio * m.material.poisson_ratio);
  const double membrane = e * m.thickness, bending = e * std::pow(m.thickness, 3) / 12.0;
  std::vector<double> mass(t.plane, 0.0);
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

// Forces and displacements that supports leave free: held components are zero, tied ones equal.
struct Space {
  const ShellModel& m;
  const std::vector<double>& mass;
  std::vector<double> inverse;  // [3][component stride]; of the sum of a tied group
  explicit Space(const ShellModel& model, const ShellState& s, const std::vector<double>& masses)
      : m(model), mass(masses) {
    const std::size_t plane = m.tables.plane;
    inverse.assign(3 * plane, 0.0);
    for (int d = 0; d < 3; ++d) {
      for (std::size_t i = 0; i < plane; ++i)
        if (mass[i] > 0.0 && !s.motion.detached[i]) inverse[d * plane + i] = 1.0 / mass[i];
      for (const int slot : m.constraints.held[d]) inverse[d * plane + slot] = 0.0;
      for (const auto& driven : m.constraints.driven)
        for (const int slot : driven.slots[d]) inverse[d * plane + slot] = 0.0;
      for (const auto& group : m.constraints.tied[d]) {
        double sum = 0.0;
        for (const int slot : group) sum += mass[slot];
        for (const int slot : group) inverse[d * plane + slot] = 1.0 / sum;
      }
    }
  }
  // Sums the forces of each tied group; every member then holds the sum.
  void gather(std::vector<double>& f) const {
    const std::size_t plane = m.tables.plane;
    for (int d = 0; d < 3; ++d)
      for (const auto& group : m.constraints.tied[d]) {
        double sum = 0.0;
        for (const int slot : group) sum += f[d * plane + slot];
        for (const int slot : group) f[d * plane + slot] = sum;
      }
  }
};

double norm_of(const std::vector<double>& f, const std::vector<double>& inverse, bool free) {
  double sum = 0.0;
  for (std::size_t i = 0; i < f.size(); ++i)
    if ((inverse[i] > 0.0) == free) sum += f[i] * f[i];
  return std::sqrt(sum);
}

// Returns the norm of unbalanced forces, divided by that of loads and weights, or of reactions. s.motion.force holds
// the shell's forces.
double relative_residual(const ShellState& s, const Space& space, const std::vector<double>& weight,
                         std::vector<double>& summed) {
  summed = s.motion.force;
  space.gather(summed);
  double outside = 0.0;
  for (std::size_t i = 0; i < weight.size(); ++i)
    outside += std::pow(weight[i] + (s.motion.external.empty() ? 0.0 : s.motion.external[i]), 2);
  const double scale = std::max(std::sqrt(outside), norm_of(s.motion.force, space.inverse, false));
  return scale > 0.0 ? norm_of(summed, space.inverse, true) / scale : 0.0;
}

RelaxationResult to_equilibrium(const ShellModel& m, ShellState& s, const RelaxationRules& rules) {
  const std::size_t plane = m.tables.plane, size = 3 * plane;
  const std::vector<double> mass = fictitious_masses(m, s);
  const Space space(m, s, mass);
  for (const auto& driven : m.constraints.driven) {
    const Vec3 u = driven.displacement(s.motion.time);
    for (int d = 0; d < 3; ++d)
      for (const int slot : driven.slots[d]) s.motion.x[d * plane + slot] = m.rest[d * plane + slot] + u[d];
  }
  std::vector<double> weight(size, 0.0), mode(size), at;
  for (int d = 0; d < 3; ++d)
    for (std::size_t i = 0; i < plane; ++i) weight[d * plane + i] = s.motion.mass[i] * rules.gravity[d];
  const auto forces = [&] {
    compute_forces(m, s, false, 0.0, rules.threads);
    for (std::size_t i = 0; i < size; ++i) s.motion.force[i] += weight[i];
  };
  std::mt19937_64 random(1);
  for (double& x : mode) x = static_cast<double>(random() >> 11) * 0x1.0p-52 - 1.0;
  const double epsilon = 1e-7 * m.spacing;
  const auto stable = [&](int iterations) {  // power iteration, continued from the last mode
    at = s.motion.x;
    const std::vector<double> f0 = s.motion.force;
    double lambda = 0.0;
    for (int it = 0; it < iterations; ++it) {
      double largest = 0.0, before = 0.0, after = 0.0;
      for (std::size_t i = 0; i < size; ++i) {
        if (space.inverse[i] == 0.0) mode[i] = 0.0;
        largest = std::max(largest, std::abs(mode[i]));
      }
      for (std::size_t i = 0; i < size; ++i) s.motion.x[i] = at[i] + epsilon * (mode[i] /= largest);
      forces();
      for (std::size_t i = 0; i < size; ++i) s.motion.force[i] = -(s.motion.force[i] - f0[i]) / epsilon;
      space.gather(s.motion.force);
      for (std::size_t i = 0; i < size; ++i) {
        const double next = s.motion.force[i] * space.inverse[i];
        before += mode[i] * mode[i], after += next * next;
        mode[i] = next;
      }
      lambda = std::sqrt(after / before);
    }
    s.motion.x = at, s.motion.force = f0;
    return kStep * 2.0 / std::sqrt(kMargin * lambda);
  };
  std::fill(s.motion.v.begin(), s.motion.v.end(), 0.0);
  RelaxationResult r;
  std::vector<double> summed;
  if (s.cracked.gathered.empty() && s.cracks.interlocks.empty()) {
    const FreeDegrees free = free_degrees(m, s);
    const std::vector<double> start = s.motion.x;
    std::vector<double> nearest = s.motion.x;
    double least = std::numeric_limits<double>::infinity();
    double furthest = 0.0;  // the shell's size, to limit steps
    for (std::size_t i = 0; i < size; ++i)
      furthest = std::max(furthest, std::abs(s.motion.x[i] - s.motion.x[i - i % plane]));
    double best = std::numeric_limits<double>::infinity();
    int since_best = 0;
    for (; r.newton < rules.most_newton; ++r.newton) {
      forces();
      if (rules.look) rules.look();
      r.residual = relative_residual(s, space, weight, summed);
      r.converged = r.residual <= rules.tolerance;
      if (!std::isfinite(r.residual) || r.converged) break;
      since_best = r.residual < 0.5 * best ? 0 : since_best + 1;
      best = std::min(best, r.residual);
      if (since_best > kPatience && best < kRoundOff) return r;  // as near as round-off allows
      const std::vector<double> step = newton_step(m, s, free, summed, forces);
      if (step.empty()) break;
      double left = 0.0, done = 0.0;  // work of the residual on the step; work of the loads so far
      for (std::size_t i = 0; i < size; ++i) {
        left += s.motion.force[i] * step[i];
        done += (weight[i] + (s.motion.external.empty() ? 0.0 : s.motion.external[i])) * (s.motion.x[i] - start[i]);
      }
      if (std::abs(left) <= rules.tolerance * rules.tolerance * std::abs(done)) {
        r.converged = true;
        break;
      }
      if (std::abs(left) < least) least = std::abs(left), nearest = s.motion.x;
      if (std::abs(left) > kWorse * least && least < kRoundOff * std::abs(done)) {  // round-off dominates
        s.motion.x = nearest;
        return r;
      }
      double longest = 0.0;
      for (const double u : step) longest = std::max(longest, std::abs(u));
      // Shortens the step until the residual's work on it has fallen (Crisfield's line search).
      const std::vector<double> from = s.motion.x;
      double share = std::min(1.0, kLongestStep * furthest / longest);
      for (int halving = 0;; ++halving, share *= 0.5) {
        for (std::size_t i = 0; i < size; ++i) s.motion.x[i] = from[i] + share * step[i];
        if (halving == kMostHalvings) break;
        forces();
        double slope = 0.0;
        for (std::size_t i = 0; i < size; ++i) slope += s.motion.force[i] * step[i];
        if (std::abs(slope) <= kFallen * std::abs(left)) break;
      }
    }
    if (r.converged) return r;
    s.motion.x = start;
  }
  double dt = 0.0, last = 0.0;
  bool resting = true;
  for (; r.steps < rules.most_steps; ++r.steps) {
    forces();
    if (r.steps % kMeasureEvery == 0) dt = stable(r.steps == 0 ? kFirstIterations : kLaterIterations);
    if (r.steps % kCheckEvery == 0) {
      if (rules.look) rules.look();
      r.residual = relative_residual(s, space, weight, summed);
      r.converged = r.residual <= rules.tolerance;
      if (!std::isfinite(r.residual) || r.converged) break;
    }
    space.gather(s.motion.force);
    double kinetic = 0.0;
    const double kick = resting ? 0.5 * dt : dt;
    for (std::size_t i = 0; i < size; ++i) {
      s.motion.v[i] += kick * s.motion.force[i] * space.inverse[i];
      kinetic += s.motion.v[i] * s.motion.v[i] * mass[i % plane];
    }
    resting = kinetic < last;  // past a peak
    last = resting ? 0.0 : kinetic;
    if (resting)
      std::fill(s.motion.v.begin(), s.motion.v.end(), 0.0);
    else
      for (std::size_t i = 0; i < size; ++i) s.motion.x[i] += dt * s.motion.v[i];
  }
  return r;
}

}  // namespace

RelaxationResult relax(const ShellModel& m, ShellState& s, const RelaxationRules& rules) {
  const RelaxationResult r = to_equilibrium(m, s, rules);
  std::fill(s.motion.v.begin(), s.motion.v.end(), 0.0);
  compute_forces(m, s, false, s.layers.plastic.empty() ? 0.0 : 1.0,
                 rules.threads);  // without the weights; plastic strain stays
  return r;
}

}  // namespace sunder::shell
