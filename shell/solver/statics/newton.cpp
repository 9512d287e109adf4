#include "shell/solver/statics/newton.h"

#include <algorithm>

#include <Eigen/SparseLU>

namespace sunder::shell {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

constexpr double kPenalty = 100.0;  // of constraints, in largest stiffnesses: a larger one would cost digits
constexpr int kMostRounds = 40;     // of the method of multipliers
constexpr double kKept = 1e-12;     // violation that is left, as a share of what the step would make

/// Solves with a tangent stiffness.
class Factors {
 public:
  Factors(const Matrix& tangent, bool symmetric) : symmetric_(symmetric) {
    if (!symmetric) {
      general_.compute(tangent);
      return;
    }
    // The mean of both triangles halves the round-off of differences, which is large for thin elements at a pole.
    const Matrix mean = 0.5 * (tangent + Matrix(tangent.transpose()));
    own_.compute(mean);
  }
  bool good() const { return (symmetric_ ? own_.info() : general_.info()) == Eigen::Success; }
  Eigen::VectorXd solve(const Eigen::VectorXd& right) const {
    return symmetric_ ? Eigen::VectorXd(own_.solve(right)) : Eigen::VectorXd(general_.solve(right));
  }
  bool unstable() const { return symmetric_ && (own_.vectorD().array() < 0.0).any(); }

 private:
  bool symmetric_;
  Eigen::SimplicialLDLT<Matrix> own_;
  Eigen::SparseLU<Matrix> general_;
};

// Solves K u + G^T m = f, G u = -c by the method of multipliers (Hestenes 1969): K + r G^T G is positive where K is
// against displacements that keep the constraints.
Eigen::VectorXd constrained(const Matrix& tangent, bool symmetric, const Matrix& gradients, const Eigen::VectorXd& c,
                            const Eigen::VectorXd& force, bool& unstable) {
  const Matrix product = gradients.transpose() * gradients;
  const double steepest = product.diagonal().maxCoeff();  // 0: the directions of all constraints are held
  const double penalty = steepest > 0.0 ? kPenalty * tangent.diagonal().maxCoeff() / steepest : 0.0;
  const Factors factors(Matrix(tangent + penalty * product), symmetric);
  if (!factors.good()) return {};
  unstable = factors.unstable();
  Eigen::VectorXd u, multipliers = Eigen::VectorXd::Zero(c.size());
  for (int k = 0; k < kMostRounds; ++k) {
    u = factors.solve(force - gradients.transpose() * (multipliers + penalty * c));
    const Eigen::VectorXd off = gradients * u + c;
    const double most = (gradients.cwiseAbs() * u.cwiseAbs()).maxCoeff() + c.cwiseAbs().maxCoeff();
    if (off.cwiseAbs().maxCoeff() <= kKept * most) break;
    multipliers += penalty * off;
  }
  return u;
}

}  // namespace

NewtonStep newton_step(const ShellModel& m, ShellState& s, const FreeDegrees& free, const std::vector<double>& residual,
                       Differences differences, const std::function<void()>& forces) {
  const Matrix tangent = tangent_stiffness(m, s, free, differences, forces);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(free.count);
  for (std::size_t k = 0; k < residual.size(); ++k)
    if (free.number[k] >= 0) right[free.number[k]] = residual[k];
  const Factors factors(tangent, !m.loads.rotate_with_surface());  // else the tangent is not symmetric
  if (!factors.good()) return {};
  const Eigen::VectorXd step = factors.solve(right);
  if (!step.allFinite()) return {};
  NewtonStep out;
  out.unstable = factors.unstable();
  out.u.assign(residual.size(), 0.0);
  for (std::size_t k = 0; k < residual.size(); ++k)
    if (free.number[k] >= 0) out.u[k] = step[free.number[k]];
  return out;
}

NewtonStep newton_step(Balance& balance, const std::vector<double>& residual, Differences differences) {
  const JoinedShells& joined = balance.joined();
  const JoinedDegrees& free = balance.degrees();
  if (!joined.stitching)
    return newton_step(*joined.shells[0].model, *joined.shells[0].state, free.own(0), residual, differences,
                       [&] { balance.compute(0); });
  Matrix tangent = joined_stiffness(balance, differences);
  if (free.constrained()) tangent += free.curvature(balance.x, balance.multipliers());
  const bool symmetric = !balance.rotates();
  const Eigen::VectorXd force = free.reduced(residual);
  NewtonStep out;
  Eigen::VectorXd step;
  if (free.constrained()) {
    step = constrained(tangent, symmetric, free.gradients(balance.x), free.violations(balance.x), force, out.unstable);
  } else {
    const Factors factors(tangent, symmetric);
    if (!factors.good()) return {};
    step = factors.solve(force), out.unstable = factors.unstable();
  }
  if (step.size() == 0 || !step.allFinite()) return {};
  out.u = free.expanded(step);
  return out;
}

Eigen::SparseMatrix<double> joined_stiffness(Balance& balance, Differences differences) {
  const JoinedShells& joined = balance.joined();
  std::vector<Matrix> own(joined.shells.size());
  balance.each_shell([&](std::size_t k) {
    own[k] = tangent_stiffness(*joined.shells[k].model, *joined.shells[k].state, balance.degrees().own(k), differences,
                               [&] { balance.compute(k); });
  });
  return balance.degrees().assembled(own);
}

}  // namespace sunder::shell
