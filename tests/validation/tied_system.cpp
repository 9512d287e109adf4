#include "tests/validation/tied_system.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <fmt/format.h>
#include <Eigen/SparseLU>

#include "coupler/core/error.h"
#include "shell/solver/forces.h"
#include "shell/solver/joining/stitching.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/validation/ritz.h"

namespace sunder::validation {

using namespace sunder::shell;

namespace {

using Matrix = Eigen::SparseMatrix<double>;

using std::numbers::pi;
constexpr int kSubspaceIterations = 60;  // of subspaces, which converge in fewer
constexpr double kTolerance = 1e-7;      // of places where borders meet [m]

}  // namespace

std::vector<const ShellModel*> Pieces::all() const {
  std::vector<const ShellModel*> out;
  for (const ShellModel& m : models) out.push_back(&m);
  return out;
}

std::vector<BorderedPatch> Pieces::bordered() const {
  std::vector<BorderedPatch> out;
  for (std::size_t k = 0; k < models.size(); ++k)
    out.push_back({&patches[k], &models[k].trim.loops, 0, models[k].name});
  return out;
}

void Pieces::find_seams() {
  stitches.seams =
      find_trim_seams(bordered(), kTolerance,
                      std::vector<std::vector<Join>>(models.size(), std::vector<Join>(models.size(), Join::kClamped)));
}

struct TiedSystem::Factors {
  Eigen::SparseLU<Matrix> lu;
};

TiedSystem::TiedSystem(const Pieces& pieces) : pieces_(pieces), factors_(std::make_unique<Factors>()) {
  std::vector<Eigen::Triplet<double>> stiffness;
  for (const ShellModel& m : pieces.models) {
    ShellState s = make_state(m, Vec3::Zero(), 0);
    free_.push_back(free_degrees(m, s));
    first_.push_back(count_);
    Matrix k =
        tangent_stiffness(m, s, free_.back(), Differences::kFourthOrder, [&] { compute_forces(m, s, false, 0.0, 1); });
    k = (0.5 * (k + Matrix(k.transpose()))).eval();
    for (int c = 0; c < k.outerSize(); ++c)
      for (Matrix::InnerIterator it(k, c); it; ++it)
        stiffness.emplace_back(count_ + static_cast<int>(it.row()), count_ + static_cast<int>(it.col()), it.value());
    mass_.conservativeResize(count_ + free_.back().count);
    load_.conservativeResize(count_ + free_.back().count);
    for (std::size_t i = 0; i < free_.back().number.size(); ++i)
      if (const int n = free_.back().number[i]; n >= 0) {
        mass_[count_ + n] = s.motion.mass[i % m.tables.component_stride];
        load_[count_ + n] = s.motion.external.empty() ? 0.0 : s.motion.external[i];
      }
    count_ += free_.back().count;
  }
  stiffness_.resize(count_, count_);
  stiffness_.setFromTriplets(stiffness.begin(), stiffness.end());
  for (const Seam& seam : pieces.stitches.seams)
    for (const auto& row : seam_rows(seam, pieces.all()).ties)
      for (int d = 0; d < 3; ++d) {
        bool any = false;
        for (const WeightedSlot& t : row)
          if (const int n = degree(t.shell, t.slot, d); n >= 0) ties_.emplace_back(rows_, n, t.weight), any = true;
        rows_ += any;
      }
}

TiedSystem::~TiedSystem() = default;

int TiedSystem::degree(int shell, int slot, int axis) const {
  const int n =
      free_[shell].number[static_cast<std::size_t>(axis) * pieces_.models[shell].tables.component_stride + slot];
  return n < 0 ? -1 : first_[shell] + n;
}

Eigen::MatrixXd TiedSystem::solve(const Eigen::MatrixXd& loads, double held) {
  if (held != held_) factorise(held);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(count_ + rows_, loads.cols());
  right.topRows(count_) = loads;
  return Eigen::MatrixXd(factors_->lu.solve(right)).topRows(count_);
}

std::vector<double> TiedSystem::frequencies(double held, int rigid) {
  const int vectors = kTiedModes + rigid + 8;
  std::mt19937_64 random(3);
  Eigen::MatrixXd x(count_, vectors);
  for (Eigen::Index k = 0; k < x.size(); ++k) x.data()[k] = static_cast<double>(random() >> 11) * 0x1.0p-53 - 0.5;
  Eigen::VectorXd values = Eigen::VectorXd::Zero(vectors);
  for (int it = 0; it < kSubspaceIterations; ++it) {
    x = solve(mass_.asDiagonal() * x, held);
    const Eigen::MatrixXd k = x.transpose() * (stiffness_ * x), m = x.transpose() * (mass_.asDiagonal() * x);
    const Eigenpairs reduced = ritz_pairs(0.5 * (k + k.transpose()), 0.5 * (m + m.transpose()));
    x = (x * reduced.vectors).eval();
    const double change = (reduced.values - values).head(kTiedModes + rigid).cwiseAbs().maxCoeff();
    values = reduced.values;
    if (change <= 1e-9 * values[kTiedModes + rigid - 1]) break;
    require(it + 1 < kSubspaceIterations, "frequencies still change by {:.3g} of their squares",
            change / values[kTiedModes + rigid - 1]);
  }
  std::vector<double> out;
  for (int k = rigid; k < rigid + kTiedModes; ++k) {
    const Eigen::VectorXd shape = x.col(k);
    out.push_back(std::sqrt(values[k] * shape.dot(mass_.cwiseProduct(shape)) / consistent(shape)) / (2.0 * pi));
  }
  return out;
}

double TiedSystem::value(const Eigen::VectorXd& u, int shell, const Vec2& at, int axis) const {
  double w = 0.0;
  for (const GatheredFunction& f : shell_functions(pieces_.models[shell], at))
    if (const int n = degree(shell, f.slot, axis); n >= 0) w += f.n[0] * u[n];
  return w;
}

void TiedSystem::factorise(double held) {
  std::vector<Eigen::Triplet<double>> all;
  for (int c = 0; c < stiffness_.outerSize(); ++c)
    for (Matrix::InnerIterator it(stiffness_, c); it; ++it)
      all.emplace_back(static_cast<int>(it.row()), static_cast<int>(it.col()), it.value());
  for (int k = 0; k < count_; ++k) all.emplace_back(k, k, held * mass_[k]);
  const double scale = stiffness_.diagonal().maxCoeff();
  for (const auto& t : ties_)
    all.emplace_back(count_ + t.row(), t.col(), scale * t.value()),
        all.emplace_back(t.col(), count_ + t.row(), scale * t.value());
  Matrix whole(count_ + rows_, count_ + rows_);
  whole.setFromTriplets(all.begin(), all.end());
  factors_->lu.compute(whole);
  require(factors_->lu.info() == Eigen::Success, "the system of tied pieces cannot be factorised");
  held_ = held;
}

double TiedSystem::consistent(const Eigen::VectorXd& u) const {
  double sum = 0.0;
  std::vector<GatheredFunction> functions;
  for (std::size_t k = 0; k < pieces_.models.size(); ++k) {
    const ShellModel& m = pieces_.models[k];
    for (int q = 0; q < m.tables.blocks(); ++q)
      for (int e = 0; e < m.tables.spans_u; ++e) {
        const double area = m.tables.metric[m.tables.at(q, kMetricFields, kArea, e)];
        if (area == 0.0) continue;
        shell_functions(m, q, e, functions);
        Vec3 at = Vec3::Zero();
        for (const GatheredFunction& f : functions)
          for (int d = 0; d < 3; ++d)
            if (const int n = degree(static_cast<int>(k), f.slot, d); n >= 0) at[d] += f.n[0] * u[n];
        sum += m.material.density * m.thickness * area * at.squaredNorm();
      }
  }
  return sum;
}

double step_of(const Pieces& pieces, int threads) {
  std::vector<ShellState> states;
  for (const ShellModel& m : pieces.models) states.push_back(make_state(m, Vec3::Zero(), 0));
  if (states.size() == 1) return stable_step(pieces.models[0], states[0], kStepIterations, threads, true);
  std::vector<ShellRef> refs;
  for (std::size_t k = 0; k < states.size(); ++k) refs.push_back({&pieces.models[k], &states[k]});
  Stitching stitching(pieces.stitches, pieces.all());
  stitching.move_masses(refs);
  return stable_step(refs, stitching, 4 * kJoinedIterations, threads, std::vector<char>(refs.size(), 1));
}

void add_frequencies(Report& r, const std::string& name, TiedSystem& tied, TiedSystem& whole, double held, int rigid) {
  const std::vector<double> found = tied.frequencies(held, rigid), wanted = whole.frequencies(held, rigid);
  for (int k = 0; k < kTiedModes; ++k)
    r.add(fmt::format("{}_frequency_{}", name, k + 1), found[k], wanted[k], 0.01, 0.0);
}

}  // namespace sunder::validation
