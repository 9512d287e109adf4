#include "shell/solver/statics/modes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <Spectra/SymEigsShiftSolver.h>
#include <Eigen/Dense>

#include "coupler/core/error.h"
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
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> all{Eigen::MatrixXd(a)};
    return {all.eigenvalues(), all.eigenvectors()};
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
Eigen::MatrixXd rigid_motions(const ShellModel& m, const ShellState& s, const FreeDegrees& free,
                              const Eigen::VectorXd& root_mass) {
  const std::size_t stride = m.tables.component_stride;
  Vec3 middle = Vec3::Zero();
  for (int i = 0; i < m.control_points(); ++i) middle += s.position(m.tables.slot(i)) / m.control_points();
  double size = 0.0;
  for (int i = 0; i < m.control_points(); ++i) size = std::max(size, (s.position(m.tables.slot(i)) - middle).norm());
  Eigen::MatrixXd motion = Eigen::MatrixXd::Zero(free.count, 6);
  std::vector<Eigen::Matrix<double, 1, 6>> constraints;
  std::vector<char> seen(free.count, 0);
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    if (s.motion.detached[slot]) continue;
    for (int d = 0; d < 3; ++d) {
      Eigen::Matrix<double, 1, 6> row = Eigen::Matrix<double, 1, 6>::Zero();
      row[d] = 1.0;
      for (int e = 0; e < 3; ++e) row[3 + e] = Vec3::Unit(e).cross(s.position(slot) - middle)[d] / size;
      const int n = free.number[d * stride + slot];
      if (n < 0)
        constraints.push_back(row);
      else if (seen[n])
        constraints.push_back(row - motion.row(n));
      else
        seen[n] = 1, motion.row(n) = row;
    }
  }
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  for (const auto& row : constraints) normal += row.transpose() * row;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(normal);
  int still = 0;
  while (still < 6 && solver.eigenvalues()[still] <= kStays * kStays) ++still;
  if (still == 0) return Eigen::MatrixXd(free.count, 0);
  const Eigen::MatrixXd scaled = root_mass.asDiagonal() * motion * solver.eigenvectors().leftCols(still);
  Eigen::HouseholderQR<Eigen::MatrixXd> qr(scaled);
  return qr.householderQ() * Eigen::MatrixXd::Identity(free.count, still);
}

// Leaves only the motions whose stiffness is at most `most` [1/s^2]: loads may resist the others, as a pendulum's do.
Eigen::MatrixXd without_stiffness(const Matrix& a, const Eigen::MatrixXd& rigid, double most) {
  if (rigid.cols() == 0) return rigid;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(rigid.transpose() * (a * rigid));
  int loose = 0;
  while (loose < rigid.cols() && std::abs(solver.eigenvalues()[loose]) <= most) ++loose;
  return rigid * solver.eigenvectors().leftCols(loose);
}

// Returns twice the kinetic energy of unit velocities along `shape`, over the mass [kg]: u^T M u with the consistent M.
double consistent_product(const ShellModel& m, const std::vector<double>& shape) {
  const RowTables& t = m.tables;
  const std::size_t stride = t.component_stride;
  std::vector<GatheredFunction> functions;
  double sum = 0.0;
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e) {
      const double area = t.metric[t.at(q, kMetricFields, kArea, e)];
      if (area == 0.0) continue;
      Vec3 u = Vec3::Zero();
      shell_functions(m, q, e, functions);
      for (const GatheredFunction& f : functions)
        for (int d = 0; d < 3; ++d) u[d] += f.n[0] * shape[d * stride + f.slot];
      sum += area * u.squaredNorm();
    }
  return m.material.density * m.thickness * sum;
}

}  // namespace

ModeSet vibration_modes(const ShellModel& m, ShellState& s, int count, const std::function<void()>& forces) {
  require(is_uncracked(m, s), "shell '{}': modes are of shells without cracks; leave out its cuts", m.name);
  const FreeDegrees free = free_degrees(m, s);
  const std::size_t stride = m.tables.component_stride;
  ModeSet out;
  out.degrees = free.count;
  Matrix a = tangent_stiffness(m, s, free, Differences::kFourthOrder, forces);
  const Matrix transposed = a.transpose();
  out.asymmetry = a.norm() > 0.0 ? Matrix(a - transposed).norm() / a.norm() : 0.0;
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(free.count);
  for (std::size_t k = 0; k < free.number.size(); ++k)
    if (free.number[k] >= 0) mass[free.number[k]] += s.motion.mass[k % stride];
  const Eigen::VectorXd root = mass.cwiseSqrt(), inverse = root.cwiseInverse();
  a = 0.5 * (a + transposed);
  a = inverse.asDiagonal() * a * inverse.asDiagonal();
  double largest = 0.0;  // Gershgorin's bound of the largest eigenvalue
  for (int k = 0; k < a.outerSize(); ++k) {
    double sum = 0.0;
    for (Matrix::InnerIterator it(a, k); it; ++it) sum += std::abs(it.value());
    largest = std::max(largest, sum);
  }
  const double shift = kShift * largest;
  const Eigen::MatrixXd rigid = without_stiffness(a, rigid_motions(m, s, free, root), shift);
  out.rigid = static_cast<int>(rigid.cols());
  require(
      count + out.rigid <= free.count,
      "shell '{}': {} modes are asked for, but it has {} free displacements, {} of them rigid; ask for fewer, or take "
      "more elements",
      m.name, count, free.count, out.rigid);
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
    mode.shape.assign(free.number.size(), 0.0);
    const Eigen::VectorXd u = inverse.cwiseProduct(found.vectors.col(k));
    for (std::size_t i = 0; i < free.number.size(); ++i)
      if (free.number[i] >= 0) mode.shape[i] = u[free.number[i]];
    const double stiffness = found.values[k];  // of the shape, whose lumped mass is 1
    if (stiffness > 0.0) {
      mode.in_run = std::sqrt(stiffness) / (2.0 * std::numbers::pi);
      mode.frequency = std::sqrt(stiffness / consistent_product(m, mode.shape)) / (2.0 * std::numbers::pi);
    }
    double length = 0.0, sign = 1.0;
    for (int i = 0; i < m.control_points(); ++i) {
      const Vec3 v = s.at(mode.shape, m.tables.slot(i));
      if (v.norm() <= length * (1.0 + 1e-9)) continue;
      length = v.norm();
      int axis = 0;
      v.cwiseAbs().maxCoeff(&axis);
      sign = v[axis] < 0.0 ? -1.0 : 1.0;
    }
    for (double& v : mode.shape) v *= sign / length;
  }
  return out;
}

}  // namespace sunder::shell
