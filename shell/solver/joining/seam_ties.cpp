#include "shell/solver/joining/seam_ties.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>

#include "coupler/core/error.h"
#include "shell/fracture/constants.h"
#include "shell/solver/model.h"

namespace sunder::shell {
namespace {

constexpr double kTieSpacing = 1.0;  // of hat functions [elements of the coarser side]
constexpr int kFewestClosed = 3;     // hat functions on a seam that goes round
constexpr double kNoWeight = 1e-13;  // of the largest weight of a row
constexpr double kMostChange = 0.1;  // of the largest weight: changes of weights that close a gap
constexpr double kFlat = 1e-12;      // least over largest spread of control points that make a direction
constexpr double kRidge = 1e-12;     // of the diagonal: rows may say nearly the same
constexpr int kPasses = 3;           // of solutions, each of which takes away the round-off of the one before
constexpr int kBendSteps = 6;        // of Newton's method for all creases; three suffice
constexpr double kBent = 1e-12;      // of a length: round-off
constexpr double kAligned = 1e-14;   // of the velocities: round-off

using Row = std::map<std::pair<int, int>, double>;

void add(Row& row, int shell, const std::vector<GatheredFunction>& functions, double value, const Vec2& slope) {
  for (const GatheredFunction& f : functions)
    row[{shell, f.slot}] += value * f.n[0] + slope.x() * f.n[1] + slope.y() * f.n[2];
}

Vec3 rest_of(const ShellModel& m, int slot) {
  const std::size_t plane = m.tables.plane;
  return {m.rest[slot], m.rest[plane + slot], m.rest[2 * plane + slot]};
}

Vec3 sum_of(const Row& row, const std::vector<const ShellModel*>& shells) {
  Vec3 sum = Vec3::Zero();
  for (const auto& [at, weight] : row) sum += weight * rest_of(*shells[at.first], at.second);
  return sum;
}

// Changes the weights as little as possible, so that their sum stays and the sum at rest is zero. Borders are apart by
// tolerances, or by the sag of polygons. Where all control points are in one plane, a gap across it stays.
void close_gap(Row& row, const std::vector<const ShellModel*>& shells) {
  for (int pass = 0; pass < 2; ++pass) {  // the second takes away the round-off of the first
    const Vec3 gap = sum_of(row, shells);
    Vec3 middle = Vec3::Zero();
    for (const auto& [at, weight] : row)
      middle += rest_of(*shells[at.first], at.second) / static_cast<double>(row.size());
    Mat3 spread = Mat3::Zero();
    double most = 0.0;
    for (const auto& [at, weight] : row) {
      const Vec3 d = rest_of(*shells[at.first], at.second) - middle;
      spread += d * d.transpose(), most = std::max(most, std::abs(weight));
    }
    const Eigen::SelfAdjointEigenSolver<Mat3> axes(spread);
    Vec3 way = Vec3::Zero();
    for (int d = 0; d < 3; ++d)
      if (axes.eigenvalues()[d] > kFlat * axes.eigenvalues()[2])
        way -= axes.eigenvectors().col(d).dot(gap) / axes.eigenvalues()[d] * axes.eigenvectors().col(d);
    double change = 0.0;
    for (const auto& [at, weight] : row)
      change = std::max(change, std::abs(way.dot(rest_of(*shells[at.first], at.second) - middle)));
    if (change > kMostChange * most) return;
    for (auto& [at, weight] : row) weight += way.dot(rest_of(*shells[at.first], at.second) - middle);
  }
}

std::vector<WeightedSlot> listed(const Row& row) {
  double most = 0.0;
  for (const auto& [at, weight] : row) most = std::max(most, std::abs(weight));
  std::vector<WeightedSlot> out;
  for (const auto& [at, weight] : row)
    if (std::abs(weight) > kNoWeight * most) out.push_back({at.first, at.second, weight});
  return out;
}

}  // namespace

SeamRows seam_rows(const Seam& seam, const std::vector<const ShellModel*>& shells) {
  const ShellModel &a = *shells[seam.first], &b = *shells[seam.second];
  const double element = std::max(a.spacing, b.spacing);
  const int spans = std::max(seam.closed ? kFewestClosed : 1, static_cast<int>(seam.length / (kTieSpacing * element)));
  const int count = seam.closed ? spans : spans + 1;
  const bool sharp = seam.angle >= kSharpCrease, clamped = seam.join == Join::kClamped;
  std::vector<Row> position(count), slope(count);
  std::vector<double> all(count, 0.0);
  for (const SeamPlace& place : seam.places) {
    const auto of_a = shell_functions(a, place.first), of_b = shell_functions(b, place.second);
    const double at = place.along / seam.length * spans;
    const int before = std::min(spans - 1, static_cast<int>(at));
    for (const int k : {before, before + 1}) {
      const double weight = place.length * (1.0 - std::abs(at - k));
      const int row = k % count;
      all[row] += weight;
      add(position[row], seam.first, of_a, weight, Vec2::Zero());
      add(position[row], seam.second, of_b, -weight, Vec2::Zero());
      if (!clamped) continue;
      // Directions into the patches are opposite on a smooth seam; their difference tells the angle of a sharp crease.
      add(slope[row], seam.first, of_a, 0.0, weight * element * place.into_first);
      add(slope[row], seam.second, of_b, 0.0, (sharp ? -weight : weight) * element * place.into_second);
    }
  }
  SeamRows out;
  for (int k = 0; k < count; ++k) {
    for (auto& [at, weight] : position[k]) weight /= all[k];
    for (auto& [at, weight] : slope[k]) weight /= all[k];
    close_gap(position[k], shells);
    out.ties.push_back(listed(position[k]));
    if (!clamped) continue;
    if (seam.smooth) close_gap(slope[k], shells);
    (seam.smooth ? out.ties : out.creases).push_back(listed(slope[k]));
  }
  return out;
}

// The matrix G M^-1 G^T of the rows for each axis, factorised, with the inverse masses of which it is made.
struct SeamTies::Solver {
  std::vector<std::pair<int, int>> points;               // shell, slot
  std::vector<double> inverse;                           // of the mass of each point
  std::vector<int> rows;                                 // that hold
  Eigen::SparseMatrix<double, Eigen::RowMajor> weights;  // [row][point]
  std::vector<int> creases;                              // that hold
  Eigen::MatrixXd bends;                                 // [crease][point]
  // What velocities [point][crease], and creases [crease][crease], gain by unit impulses on creases that part no tie.
  std::array<Eigen::MatrixXd, 3> response, coupling;
  std::array<Eigen::VectorXd, 3> mobility;  // [axis][point]
  std::array<std::shared_ptr<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>>, 3> factors;
};

SeamTies::Row SeamTies::row_of(std::vector<WeightedSlot> terms, const std::vector<const ShellModel*>& shells) {
  Row row{std::move(terms)};
  for (const WeightedSlot& t : row.terms) {
    const ShellModel& m = *shells[t.shell];
    row.rest += t.weight * rest_of(m, t.slot);
    for (int d = 0; d < 3; ++d) {
      const auto has = [&](const std::vector<int>& slots) {
        return std::find(slots.begin(), slots.end(), t.slot) != slots.end();
      };
      const auto& driven = m.constraints.driven;
      const auto& tied = m.constraints.tied[d];
      require(
          std::none_of(driven.begin(), driven.end(), [&](const auto& part) { return has(part.slots[d]); }) &&
              std::none_of(tied.begin(), tied.end(), has),
          "a support of shell '{}' moves, or is one of symmetry, and its part ({:.4g}, {:.4g}) lies at a seam along "
          "a trim; hold another part",
          m.name, m.parameter_of_slot[t.slot].x(), m.parameter_of_slot[t.slot].y());
    }
  }
  return row;
}

SeamTies::SeamTies(std::vector<std::vector<WeightedSlot>> rows, std::vector<std::vector<WeightedSlot>> creases,
                   const std::vector<const ShellModel*>& shells) {
  for (const ShellModel* m : shells) {
    auto& fixed = fixed_.emplace_back();
    for (int d = 0; d < 3; ++d) {
      fixed[d].assign(m->tables.plane, 0);
      for (const int slot : m->constraints.held[d]) fixed[d][slot] = m->held[slot] == 0;
    }
  }
  for (auto& terms : rows) rows_.push_back(row_of(std::move(terms), shells));
  for (auto& terms : creases) creases_.push_back(row_of(std::move(terms), shells));
}

const SeamTies::Solver& SeamTies::solver(const std::vector<ShellRef>& shells) {
  const auto inverse_mass = [&](const std::pair<int, int>& at) {
    return shells[at.first].state->motion.inverse_mass[at.second];
  };
  if (solver_) {
    bool same = true;
    for (std::size_t k = 0; k < solver_->points.size() && same; ++k)
      same = solver_->inverse[k] == inverse_mass(solver_->points[k]);
    if (same) return *solver_;
  }
  auto s = std::make_shared<Solver>();
  std::map<std::pair<int, int>, int> number;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    if (!rows_[r].holds) continue;
    s->rows.push_back(static_cast<int>(r));
    for (const WeightedSlot& t : rows_[r].terms) number.try_emplace({t.shell, t.slot}, 0);
  }
  for (std::size_t r = 0; r < creases_.size(); ++r) {
    if (!creases_[r].holds) continue;
    s->creases.push_back(static_cast<int>(r));
    for (const WeightedSlot& t : creases_[r].terms) number.try_emplace({t.shell, t.slot}, 0);
  }
  for (auto& [at, n] : number) {
    n = static_cast<int>(s->points.size());
    s->points.push_back(at), s->inverse.push_back(inverse_mass(at));
  }
  std::vector<Eigen::Triplet<double>> terms;
  for (std::size_t r = 0; r < s->rows.size(); ++r)
    for (const WeightedSlot& t : rows_[s->rows[r]].terms)
      terms.emplace_back(static_cast<int>(r), number.at({t.shell, t.slot}), t.weight);
  s->weights.resize(static_cast<Eigen::Index>(s->rows.size()), static_cast<Eigen::Index>(s->points.size()));
  s->weights.setFromTriplets(terms.begin(), terms.end());
  for (int d = 0; d < 3; ++d) {
    s->mobility[d].resize(static_cast<Eigen::Index>(s->points.size()));
    for (std::size_t k = 0; k < s->points.size(); ++k) {
      const auto& [shell, slot] = s->points[k];
      s->mobility[d][static_cast<Eigen::Index>(k)] = fixed_[shell][d][slot] ? 0.0 : s->inverse[k];
    }
    for (int e = 0; e < d && !s->factors[d]; ++e)
      if (s->mobility[e] == s->mobility[d]) s->factors[d] = s->factors[e];
    if (s->factors[d]) continue;
    Eigen::SparseMatrix<double> matrix = s->weights * s->mobility[d].asDiagonal() * s->weights.transpose();
    for (Eigen::Index k = 0; k < matrix.rows(); ++k) {
      double& own = matrix.coeffRef(k, k);
      own = own > 0.0 ? own * (1.0 + kRidge) : 1.0;  // a row on which nothing moves asks for nothing
    }
    s->factors[d] = std::make_shared<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>>(matrix);
    ensure(s->factors[d]->info() == Eigen::Success, "ties along trimmed seams contradict one another");
  }
  const auto bends = static_cast<Eigen::Index>(s->creases.size());
  s->bends = Eigen::MatrixXd::Zero(bends, static_cast<Eigen::Index>(s->points.size()));
  for (Eigen::Index k = 0; k < bends; ++k)
    for (const WeightedSlot& t : creases_[s->creases[k]].terms) s->bends(k, number.at({t.shell, t.slot})) += t.weight;
  for (int d = 0; d < 3 && bends > 0; ++d) {
    const Eigen::MatrixXd free = s->mobility[d].asDiagonal() * s->bends.transpose();
    const Eigen::MatrixXd held = s->factors[d]->solve(Eigen::MatrixXd(s->weights * free));
    s->response[d] = free - s->mobility[d].asDiagonal() * Eigen::MatrixXd(s->weights.transpose() * held);
    s->coupling[d] = s->bends * s->response[d];
  }
  solver_ = s;
  return *solver_;
}

void SeamTies::add_forces(const std::vector<ShellRef>& shells, std::vector<double>& (*field)(ShellState&)) {
  if (rows_.empty()) return;
  const Solver& s = solver(shells);
  const auto count = static_cast<Eigen::Index>(s.points.size());
  Eigen::VectorXd force(count);
  for (int d = 0; d < 3; ++d) {
    const auto at = [&](Eigen::Index k) -> double& {
      const auto& [shell, slot] = s.points[k];
      std::vector<double>& f = field(*shells[shell].state);
      return f[static_cast<std::size_t>(d) * (f.size() / 3) + slot];
    };
    for (Eigen::Index k = 0; k < count; ++k) force[k] = at(k);
    for (int pass = 0; pass < 2; ++pass)
      force -= s.weights.transpose() * s.factors[d]->solve(s.weights * s.mobility[d].cwiseProduct(force));
    for (Eigen::Index k = 0; k < count; ++k) at(k) = force[k];
  }
}

double SeamTies::align(const std::vector<ShellRef>& shells, double dt, bool pass) {
  if (rows_.empty()) return 0.0;
  const Solver& s = solver(shells);
  const auto count = static_cast<Eigen::Index>(s.points.size());
  double lost = 0.0;
  Eigen::VectorXd v(count), x(count), rest(static_cast<Eigen::Index>(s.rows.size()));
  for (int d = 0; d < 3; ++d) {
    const auto of = [&](std::vector<double>& f, int slot) -> double& {
      return f[static_cast<std::size_t>(d) * (f.size() / 3) + slot];
    };
    for (Eigen::Index k = 0; k < count; ++k) {
      Motion& motion = shells[s.points[k].first].state->motion;
      v[k] = of(motion.v, s.points[k].second), x[k] = of(motion.x, s.points[k].second);
    }
    for (Eigen::Index r = 0; r < rest.size(); ++r) rest[r] = rows_[s.rows[r]].rest[d];
    const Eigen::VectorXd parted =
        dt > 0.0 ? Eigen::VectorXd((s.weights * x - rest) / dt) : Eigen::VectorXd::Zero(rest.size());
    const double least = kAligned * v.cwiseAbs().maxCoeff();
    Eigen::VectorXd impulse = Eigen::VectorXd::Zero(count);
    for (int k = 0; k < kPasses; ++k) {
      const Eigen::VectorXd off = s.weights * v + parted;
      if (off.cwiseAbs().maxCoeff() <= least) break;
      const Eigen::VectorXd j = s.weights.transpose() * s.factors[d]->solve(off);
      impulse -= j, v -= s.mobility[d].cwiseProduct(j);
    }
    if (impulse.isZero(0.0)) continue;
    for (Eigen::Index k = 0; k < count; ++k) {
      const auto& [shell, slot] = s.points[k];
      ShellState& state = *shells[shell].state;
      const double before = of(state.motion.v, slot);
      lost += 0.5 * impulse[k] * (-before - v[k]);
      of(state.motion.v, slot) = v[k];
      if (pass) state.pass_to_supports(slot, impulse[k] * Vec3::Unit(d));
    }
  }
  return lost;
}

void SeamTies::keep_creases(const std::vector<ShellRef>& shells, double dt) {
  if (creases_.empty()) return;
  const Solver& s = solver(shells);
  const auto count = static_cast<Eigen::Index>(s.points.size()), bends = static_cast<Eigen::Index>(s.creases.size());
  if (bends == 0) return;
  Eigen::MatrixXd x(count, 3), v(count, 3);
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto& [shell, slot] = s.points[k];
    x.row(k) = shells[shell].state->position(slot), v.row(k) = shells[shell].state->velocity(slot);
  }
  const Eigen::MatrixXd now = s.bends * x, along = now.rowwise().normalized();
  bool moved = false;
  for (int step = 0; step < kBendSteps; ++step) {
    const Eigen::MatrixXd next = now + dt * (s.bends * v);
    Eigen::VectorXd off(bends);
    double worst = 0.0;
    for (Eigen::Index k = 0; k < bends; ++k) {
      const double length = creases_[s.creases[k]].rest.norm();
      off[k] = next.row(k).norm() - length, worst = std::max(worst, std::abs(off[k]) / length);
    }
    if (worst <= kBent) break;
    const Eigen::MatrixXd line = next.rowwise().normalized();
    Eigen::MatrixXd gain = Eigen::MatrixXd::Zero(bends, bends);
    for (int d = 0; d < 3; ++d) gain += dt * (line.col(d).asDiagonal() * s.coupling[d] * along.col(d).asDiagonal());
    const Eigen::VectorXd impulse = gain.partialPivLu().solve(-off);
    for (int d = 0; d < 3; ++d) v.col(d) += s.response[d] * along.col(d).cwiseProduct(impulse);
    moved = true;
  }
  if (!moved) return;
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto& [shell, slot] = s.points[k];
    ShellState& state = *shells[shell].state;
    state.add_velocity(slot, Vec3(v.row(k)) - state.velocity(slot));
  }
}

}  // namespace sunder::shell
