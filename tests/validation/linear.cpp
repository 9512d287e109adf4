#include "tests/validation/linear.h"

#include <map>

#include <Eigen/Dense>

#include "coupler/core/error.h"
#include "shell/solver/forces.h"
#include "tests/validation/ritz.h"

namespace sunder::validation {

using namespace sunder::shell;

namespace {

// share of the smallest spacing: differences have an error of its square, and round-off over it
constexpr double kDifferenceStep = 1e-6;
// with a subspace of twice the wanted size, each reduces the error to a quarter or less
constexpr int kPowerIterations = 40;

struct Freedom {
  int shell, slot, axis;
  std::vector<std::tuple<int, int, double>> moves;  // shell, slot, share: the control point and its dependent ones
};

std::vector<Freedom> freedoms(const Stitched& s) {
  std::map<std::pair<int, int>, std::vector<std::tuple<int, int, double>>> dependents;
  const auto slot = [&](const PatchPoint& p) { return s.model(p.patch).tables.slot(p.point); };
  for (const Dependence& d : s.stitches().points)
    for (const auto& [p, weight] : d.on)
      dependents[{p.patch, slot(p)}].emplace_back(d.point.patch, slot(d.point), weight);
  std::vector<Freedom> out;
  for (int k = 0; k < static_cast<int>(s.size()); ++k) {
    const ShellModel& m = s.model(k);
    for (int i = 0; i < m.control_points(); ++i) {
      const int at = m.tables.slot(i);
      if (s.state(k).motion.inverse_mass[at] == 0.0 || s.state(k).motion.mass[at] == 0.0) continue;
      for (int d = 0; d < 3; ++d) {
        const auto& held = m.constraints.held[d];
        if (std::binary_search(held.begin(), held.end(), at)) continue;
        Freedom f{k, at, d, {{k, at, 1.0}}};
        const auto it = dependents.find({k, at});
        if (it != dependents.end()) f.moves.insert(f.moves.end(), it->second.begin(), it->second.end());
        out.push_back(std::move(f));
      }
    }
  }
  return out;
}

}  // namespace

Linear linear_response(Stitched& s, int modes) {
  const std::vector<Freedom> all = freedoms(s);
  const auto n = static_cast<Eigen::Index>(all.size());
  double spacing = 1e300;
  for (std::size_t k = 0; k < s.size(); ++k) spacing = std::min(spacing, s.model(k).spacing);
  const double step = kDifferenceStep * spacing;
  std::vector<std::vector<double>> still;  // forces at rest, before they are shared
  for (std::size_t k = 0; k < s.size(); ++k) {
    compute_forces(s.model(k), s.state(k), false, 0.0, 1);
    still.push_back(s.state(k).motion.force);
  }
  const auto force = [&](const Freedom& f) {
    const std::vector<double>& all_of = s.state(f.shell).motion.force;
    return all_of[f.axis * all_of.size() / 3 + f.slot];
  };
  s.stitching().move_forces(s.refs());
  Eigen::VectorXd load(n), mass(n);
  for (Eigen::Index i = 0; i < n; ++i)
    load[i] = force(all[i]), mass[i] = s.state(all[i].shell).motion.mass[all[i].slot];
  Eigen::MatrixXd stiffness(n, n);
  for (Eigen::Index c = 0; c < n; ++c) {
    const Freedom& f = all[c];
    const auto move = [&](double by) {
      for (const auto& [shell, slot, share] : f.moves) {
        std::vector<double>& x = s.state(shell).motion.x;
        x[f.axis * x.size() / 3 + slot] += by * share;
      }
    };
    std::vector<char> touched(s.size(), 0);
    for (const auto& [shell, slot, share] : f.moves) touched[shell] = 1;
    const auto column = [&](double sign) {
      for (std::size_t k = 0; k < s.size(); ++k)
        if (touched[k])
          compute_forces(s.model(k), s.state(k), false, 0.0, 1);
        else
          s.state(k).motion.force = still[k];
      s.stitching().move_forces(s.refs());
      for (Eigen::Index i = 0; i < n; ++i) stiffness(i, c) -= sign * force(all[i]) / (2.0 * step);
    };
    stiffness.col(c).setZero();
    move(step), column(1.0), move(-2.0 * step), column(-1.0), move(step);
  }
  stiffness = 0.5 * (stiffness + stiffness.transpose()).eval();
  const Eigen::LLT<Eigen::MatrixXd> factors(stiffness);
  require(factors.info() == Eigen::Success, "the stiffness is not positive: the supports leave the shells free");
  Linear out;
  const Eigen::VectorXd u = factors.solve(load);
  for (std::size_t k = 0; k < s.size(); ++k) out.under_load.emplace_back(s.state(k).motion.x.size(), 0.0);
  for (Eigen::Index i = 0; i < n; ++i)
    for (const auto& [shell, slot, share] : all[i].moves)
      out.under_load[shell][all[i].axis * out.under_load[shell].size() / 3 + slot] += share * u[i];
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(n, std::min<Eigen::Index>(n, 2 * modes));
  std::uint64_t random = 1;
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    random = random * 6364136223846793005ull + 1442695040888963407ull;
    x.data()[k] = static_cast<double>(random >> 33) / 0x1.0p31 - 0.5;
  }
  Eigen::VectorXd omega2;
  for (int it = 0; it < kPowerIterations && modes > 0; ++it) {
    const Eigen::MatrixXd y = factors.solve(mass.asDiagonal() * x);
    const Eigenpairs ritz = ritz_pairs(y.transpose() * (stiffness * y), y.transpose() * (mass.asDiagonal() * y));
    x = y * ritz.vectors, omega2 = ritz.values;
  }
  for (int k = 0; k < modes; ++k) out.frequencies.push_back(std::sqrt(omega2[k]));
  return out;
}

}  // namespace sunder::validation
