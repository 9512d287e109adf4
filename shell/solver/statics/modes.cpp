#include "shell/solver/statics/modes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <Spectra/SymEigsShiftSolver.h>
#include <Eigen/Dense>

#include "coupler/core/dense.h"
#include "coupler/core/error.h"
#include "shell/solver/statics/newton.h"
#include "shell/solver/statics/tangent.h"

namespace sunder::shell {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

constexpr double kShift = 1e-10;      // distance of the shift below zero, as a share of the largest eigenvalue
constexpr int kDense = 240;           // free displacements up to which all eigenpairs are computed
constexpr int kSpare = 6;             // modes beyond those that are asked for: they leave a gap to count at
constexpr int kMoreVectors = 24;      // Lanczos vectors beyond the modes
constexpr int kRestarts = 400;        // of Lanczos
constexpr double kConverged = 1e-12;  // relative error of an eigenvalue
constexpr double kGap = 1e-5;         // relative gap between two eigenvalues at which they are counted
constexpr int kTries = 4;             // with more vectors each time, where one of equal eigenvalues was missed
constexpr double kKeeping = 100.0;    // stiffness that keeps constraints of seams, in largest stiffnesses
constexpr double kStays = 1e-9;       // displacement of a support in a rigid motion, over the shell's size

/// M^-1/2 (K - shift M)^-1 M^-1/2, as Spectra wants it.
class ShiftedInverse {
 public:
  using Scalar = double;
  explicit ShiftedInverse(const Matrix& a) : a_(a) {}
  Eigen::Index rows() const { return a_.rows(); }
  Eigen::Index cols() const { return a_.cols(); }
  void set_shift(double shift) {
    Matrix shifted = a_;
    shifted.diagonal().array() -= shift;
    factors_.compute(shifted);
    if (factors_.info() != Eigen::Success)
      throw Error(Exit::kPhysics, "modes", "the tangent stiffness cannot be factorised");
  }
  void perform_op(const double* x, double* y) const {
    Eigen::Map<Eigen::VectorXd>(y, rows()) = factors_.solve(Eigen::Map<const Eigen::VectorXd>(x, rows()));
  }
  /// Number of eigenvalues below the shift.
  int below() const { return static_cast<int>((factors_.vectorD().array() < 0.0).count()); }

 private:
  const Matrix& a_;
  Eigen::SimplicialLDLT<Matrix> factors_;
};

struct Pairs {
  Eigen::VectorXd values;  // rising
  Eigen::MatrixXd vectors;
};

Pairs sorted(const Eigen::VectorXd& values, const Eigen::MatrixXd& vectors) {
  std::vector<int> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int i, int k) { return values[i] < values[k]; });
  Pairs out{values, vectors};
  for (std::size_t k = 0; k < order.size(); ++k)
    out.values[k] = values[order[k]], out.vectors.col(k) = vectors.col(order[k]);
  return out;
}

// Returns the eigenpairs of `a` next to `shift`, `wanted` of them or more.
Pairs lowest(const Matrix& a, double shift, int wanted) {
  const int n = static_cast<int>(a.rows());
  if (n <= kDense) {
    Eigenpairs all = eigenpairs(Eigen::MatrixXd(a));
    return {std::move(all.values), std::move(all.vectors)};
  }
  ShiftedInverse inverse(a);
  for (int k = wanted + kSpare, tries = 0; tries < kTries; ++tries, k += kSpare) {
    k = std::min(k, n - 1);
    Spectra::SymEigsShiftSolver<ShiftedInverse> solver(inverse, k, std::min(n, 2 * k + kMoreVectors), shift);
    solver.init();
    if (solver.compute(Spectra::SortRule::LargestMagn, kRestarts, kConverged) < k) continue;
    Pairs found = sorted(solver.eigenvalues(), solver.eigenvectors());
    // Lanczos may miss one of several equal eigenvalues. All below a gap are counted by a factorisation.
    int j = k - 1;
    while (j > wanted && found.values[j] - found.values[j - 1] < kGap * std::abs(found.values[j])) --j;
    ShiftedInverse counter(a);
    counter.set_shift(0.5 * (found.values[j - 1] + found.values[j]));
    if (counter.below() == j) return {found.values.head(j), found.vectors.leftCols(j)};
  }
  throw Error(Exit::kPhysics, "modes",
              fmt::format("{} modes do not converge; ask for fewer, or take fewer elements", wanted));
}

// Returns the rigid motions that supports leave free, as orthonormal columns in M^1/2 u.
Eigen::MatrixXd rigid_motions(const JoinedShells& joined, const JoinedDegrees& free, const Eigen::VectorXd& root_mass) {
  int points = 0;
  for (const ShellRef& r : joined.shells) points += r.model->control_points();
  const auto each = [&](auto&& f) {
    for (std::size_t k = 0; k < joined.shells.size(); ++k)
      for (int i = 0; i < joined.shells[k].model->control_points(); ++i)
        f(k, joined.shells[k].model->tables.slot(i),
          joined.shells[k].state->position(joined.shells[k].model->tables.slot(i)));
  };
  Vec3 middle = Vec3::Zero();
  each([&](std::size_t, int, const Vec3& x) { middle += x / points; });
  double size = 0.0;
  each([&](std::size_t, int, const Vec3& x) { size = std::max(size, (x - middle).norm()); });
  Eigen::MatrixXd motion = Eigen::MatrixXd::Zero(free.count(), 6);
  std::vector<Eigen::Matrix<double, 1, 6>> constraints;
  std::vector<char> seen(free.count(), 0);
  each([&](std::size_t k, int slot, const Vec3& x) {
    if (joined.shells[k].state->motion.detached[slot]) return;
    for (int d = 0; d < 3; ++d) {
      Eigen::Matrix<double, 1, 6> row = Eigen::Matrix<double, 1, 6>::Zero();
      row[d] = 1.0;
      for (int e = 0; e < 3; ++e) row[3 + e] = Vec3::Unit(e).cross(x - middle)[d] / size;
      const std::size_t entry = free.first(k) + d * joined.shells[k].model->tables.component_stride + slot;
      const int n = free.number()[entry];
      if (n < 0) {
        if (!free.dependent(entry)) constraints.push_back(row);
      } else if (seen[n]) {
        constraints.push_back(row - motion.row(n));
      } else {
        seen[n] = 1, motion.row(n) = row;
      }
    }
  });
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(6, 6);
  for (const auto& row : constraints) normal += row.transpose() * row;
  const auto [values, vectors] = eigenpairs(normal);
  int still = 0;
  while (still < 6 && values[still] <= kStays * kStays) ++still;
  if (still == 0) return Eigen::MatrixXd(free.count(), 0);
  return orthonormal(root_mass.asDiagonal() * motion * vectors.leftCols(still));
}

// Leaves only the motions whose stiffness is at most `most` [1/s^2]: loads may resist the others, as a pendulum's do.
Eigen::MatrixXd without_stiffness(const Matrix& a, const Eigen::MatrixXd& rigid, double most) {
  if (rigid.cols() == 0) return rigid;
  const auto [values, vectors] = eigenpairs(rigid.transpose() * (a * rigid));
  int loose = 0;
  while (loose < rigid.cols() && std::abs(values[loose]) <= most) ++loose;
  return rigid * vectors.leftCols(loose);
}

// Returns twice the kinetic energy of unit velocities along `shape`: u^T M u with the consistent M.
double consistent_product(const JoinedShells& joined, const JoinedDegrees& free, const std::vector<double>& shape) {
  std::vector<GatheredFunction> functions;
  double all = 0.0;
  for (std::size_t k = 0; k < joined.shells.size(); ++k) {
    const ShellModel& m = *joined.shells[k].model;
    const RowTables& t = m.tables;
    const std::size_t stride = t.component_stride, first = free.first(k);
    double sum = 0.0;
    for (int q = 0; q < t.blocks(); ++q)
      for (int e = 0; e < t.spans_u; ++e) {
        const double area = t.metric[t.at(q, kMetricFields, kArea, e)];
        if (area == 0.0) continue;
        Vec3 u = Vec3::Zero();
        shell_functions(m, q, e, functions);
        for (const GatheredFunction& f : functions)
          for (int d = 0; d < 3; ++d) u[d] += f.n[0] * shape[first + d * stride + f.slot];
        sum += area * u.squaredNorm();
      }
    all += m.material.density * m.thickness * sum;
  }
  return all;
}

// Lumped masses of free displacements, as in a run.
Eigen::VectorXd lumped(const JoinedShells& joined, const JoinedDegrees& free) {
  std::vector<double> field;
  for (const ShellRef& r : joined.shells)
    for (int d = 0; d < 3; ++d) field.insert(field.end(), r.state->motion.mass.begin(), r.state->motion.mass.end());
  free.hand_over_mass(field);
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(free.count());
  for (std::size_t k = 0; k < field.size(); ++k)
    if (free.number()[k] >= 0) mass[free.number()[k]] += field[k];
  return mass;
}

// Scales a shape so that its longest displacement is 1 and points to positive values.
void normalise(const JoinedShells& joined, const JoinedDegrees& free, std::vector<double>& shape) {
  double length = 0.0, sign = 1.0;
  for (std::size_t k = 0; k < joined.shells.size(); ++k)
    for (int i = 0; i < joined.shells[k].model->control_points(); ++i) {
      const RowTables& t = joined.shells[k].model->tables;
      const double* at = &shape[free.first(k) + t.slot(i)];
      const Vec3 v(at[0], at[t.component_stride], at[2 * t.component_stride]);
      if (v.norm() <= length * (1.0 + 1e-9)) continue;
      length = v.norm();
      int axis = 0;
      v.cwiseAbs().maxCoeff(&axis);
      sign = v[axis] < 0.0 ? -1.0 : 1.0;
    }
  for (double& v : shape) v *= sign / length;
}

void check_whole(const ShellModel& m, const ShellState& s) {
  require(is_uncracked(m, s), "shell '{}': modes are of shells without cracks; leave out its cuts", m.name);
}

// `a` is the tangent stiffness; `kept`: gradients of constraints, with no rows where there are none.
ModeSet modes_of(const JoinedShells& joined, const JoinedDegrees& free, Matrix a, const Matrix& kept, int count) {
  const std::string& name = joined.shells[0].model->name;
  ModeSet out;
  out.degrees = free.count();
  const Matrix transposed = a.transpose();
  out.asymmetry = a.norm() > 0.0 ? Matrix(a - transposed).norm() / a.norm() : 0.0;
  const Eigen::VectorXd mass = lumped(joined, free);
  const Eigen::VectorXd root = mass.cwiseSqrt(), inverse = root.cwiseInverse();
  a = 0.5 * (a + transposed);
  const double stiffest = a.diagonal().maxCoeff();
  a = inverse.asDiagonal() * a * inverse.asDiagonal();
  double largest = 0.0;  // Gershgorin's bound of the largest eigenvalue
  for (int k = 0; k < a.outerSize(); ++k) {
    double sum = 0.0;
    for (Matrix::InnerIterator it(a, k); it; ++it) sum += std::abs(it.value());
    largest = std::max(largest, sum);
  }
  if (kept.rows() > 0) {
    const Matrix product = kept.transpose() * kept;
    a += Matrix(inverse.asDiagonal() * Matrix(kKeeping * stiffest / product.diagonal().maxCoeff() * product) *
                inverse.asDiagonal());
  }
  const double shift = kShift * largest;
  const Eigen::MatrixXd rigid = without_stiffness(a, rigid_motions(joined, free, root), shift);
  out.rigid = static_cast<int>(rigid.cols());
  require(
      count + out.rigid <= free.count(),
      "shell '{}': {} modes are asked for, but it has {} free displacements, {} of them rigid; ask for fewer, or take "
      "more elements",
      name, count, free.count(), out.rigid);
  const Pairs found = lowest(a, -shift, count + out.rigid);
  std::vector<int> order(found.values.size());  // least rigid first
  std::iota(order.begin(), order.end(), 0);
  Eigen::VectorXd share = Eigen::VectorXd::Zero(found.values.size());
  if (out.rigid > 0) share = (rigid.transpose() * found.vectors).colwise().squaredNorm();
  std::stable_sort(order.begin(), order.end(), [&](int i, int k) { return share[i] < share[k]; });
  order.resize(order.size() - out.rigid);
  std::sort(order.begin(), order.end());
  for (const int k : order) {
    if (static_cast<int>(out.modes.size()) == count) break;
    Mode& mode = out.modes.emplace_back();
    mode.eigenvalue = found.values[k];
    out.unstable += mode.eigenvalue < -shift;
    mode.shape = free.expanded(inverse.cwiseProduct(found.vectors.col(k)));
    const double stiffness = found.values[k];  // of the shape, whose lumped mass is 1
    if (stiffness > 0.0) {
      mode.in_run = std::sqrt(stiffness) / (2.0 * std::numbers::pi);
      mode.frequency = std::sqrt(stiffness / consistent_product(joined, free, mode.shape)) / (2.0 * std::numbers::pi);
    }
    normalise(joined, free, mode.shape);
  }
  return out;
}

}  // namespace

ModeSet vibration_modes(const ShellModel& m, ShellState& s, int count, const std::function<void()>& forces) {
  check_whole(m, s);
  const JoinedShells joined{{{&m, &s}}, {0}, nullptr, {Vec3::Zero()}};
  const JoinedDegrees free(joined);
  return modes_of(joined, free, tangent_stiffness(m, s, free.own(0), Differences::kFourthOrder, forces), {}, count);
}

ModeSet vibration_modes(const JoinedShells& joined, int count, int threads, bool at_equilibrium) {
  for (const ShellRef& r : joined.shells) check_whole(*r.model, *r.state);
  Balance balance(joined, threads);
  const JoinedDegrees& free = balance.degrees();
  balance.compute();
  std::vector<double> summed;
  balance.residual(summed);  // for the multipliers
  Matrix stiffness = joined_stiffness(balance, Differences::kFourthOrder);
  // only forces in balance stiffen a crease
  if (at_equilibrium) stiffness += free.curvature(balance.x, balance.multipliers());
  return modes_of(joined, free, std::move(stiffness), free.gradients(balance.x), count);
}

Vibrations::Vibrations(const JoinedShells& joined, int threads) : joined_(joined), balance_(joined_, threads) {
  for (const ShellRef& r : joined_.shells) check_whole(*r.model, *r.state);
  balance_.compute();
  stiffness_ = joined_stiffness(balance_, Differences::kFourthOrder);
  kept_ = balance_.degrees().gradients(balance_.x);
}

ModeSet Vibrations::lowest(int count) const { return modes_of(joined_, balance_.degrees(), stiffness_, kept_, count); }

}  // namespace sunder::shell
