#include "shell/solver/joining/seam_ties.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>

#include "coupler/core/dense.h"
#include "coupler/core/error.h"
#include "shell/fracture/constants.h"
#include "shell/solver/model.h"

namespace sunder::shell {
namespace {

/// [h]: distance of hat functions, in elements of the coarser side.
/// numerical: finer ones would lock, since two nets have few curves in common
constexpr double kTieSpacing = 1.0;
/// [of the largest weight of a row]: change of weights that may close a gap at rest.
/// numerical: a larger one would move the place that a row ties
constexpr double kMostChange = 0.1;
constexpr double kNoWeight = 1e-13;  // of the largest weight of a row
constexpr double kFlat = 1e-12;      // least over largest spread of control points that make a direction
constexpr double kRidge = 1e-12;     // of the diagonal: rows may say nearly the same
constexpr int kPasses = 3;           // of solutions, each of which takes away the round-off of the one before
constexpr int kBendSteps = 6;        // of Newton's method for all creases; three suffice
constexpr double kBent = 1e-12;      // of a length: round-off
constexpr double kAligned = 1e-14;   // of the velocities: round-off

using TermMap = std::map<std::pair<int, int>, double>;

void add(TermMap& row, int shell, const std::vector<GatheredFunction>& functions, double value, const Vec2& slope) {
  for (const GatheredFunction& f : functions)
    row[{shell, f.slot}] += value * f.n[0] + slope.x() * f.n[1] + slope.y() * f.n[2];
}

Vec3 rest_of(const ShellModel& m, int slot) {
  const std::size_t stride = m.tables.component_stride;
  return {m.rest[slot], m.rest[stride + slot], m.rest[2 * stride + slot]};
}

// Changes the weights as little as possible, so that their sum stays and the sum of the places x(shell, slot) is zero.
// Borders are apart by tolerances, or by the sag of polygons; functions that cracks leave differ from those before.
// Where all control points are in one plane, a gap across it stays; so does one along an axis on which they spread too
// little to close it with changes below `most`, a share of the largest weight.
template <class F>
void close_gap(TermMap& row, double most_change, F&& x) {
  for (int pass = 0; pass < 2; ++pass) {  // the second takes away the round-off of the first
    Vec3 middle = Vec3::Zero(), gap = Vec3::Zero();
    double most = 0.0;
    for (const auto& [at, weight] : row) {
      middle += x(at) / static_cast<double>(row.size()), gap += weight * x(at);
      most = std::max(most, std::abs(weight));
    }
    Mat3 spread = Mat3::Zero();
    for (const auto& [at, weight] : row) spread += (x(at) - middle) * (x(at) - middle).transpose();
    const Eigen::SelfAdjointEigenSolver<Mat3> axes(spread);
    for (int flattest = 0; flattest < 3; ++flattest) {
      Vec3 way = Vec3::Zero();
      for (int d = flattest; d < 3; ++d)
        if (axes.eigenvalues()[d] > kFlat * axes.eigenvalues()[2])
          way -= axes.eigenvectors().col(d).dot(gap) / axes.eigenvalues()[d] * axes.eigenvectors().col(d);
      double change = 0.0;
      for (const auto& [at, weight] : row) change = std::max(change, std::abs(way.dot(x(at) - middle)));
      if (change > most_change * most) continue;
      for (auto& [at, weight] : row) weight += way.dot(x(at) - middle);
      break;
    }
  }
}

void close_gap(TermMap& row, const std::vector<const ShellModel*>& shells) {
  close_gap(row, kMostChange, [&](const std::pair<int, int>& at) { return rest_of(*shells[at.first], at.second); });
}

std::vector<WeightedSlot> listed(const TermMap& row) {
  double most = 0.0;
  for (const auto& [at, weight] : row) most = std::max(most, std::abs(weight));
  std::vector<WeightedSlot> out;
  for (const auto& [at, weight] : row)
    if (std::abs(weight) > kNoWeight * most) out.push_back({at.first, at.second, weight});
  return out;
}

// The sum of differences of position, or of slope over `element` [m], at the places of a hat. of_a, of_b: [place].
template <class Functions>
TermMap weighed(const Seam& seam, const Hat& hat, const Functions& of_a, const Functions& of_b, double element,
                bool slope) {
  TermMap row;
  const bool sharp = seam.angle >= kSharpCrease;
  for (std::size_t k = 0; k < hat.places.size(); ++k) {
    const SeamPlace& place = seam.places[hat.places[k]];
    const double weight = hat.weights[k];
    const auto &a = of_a.at(hat.places[k]).functions, &b = of_b.at(hat.places[k]).functions;
    if (slope) {
      // Directions into the patches are opposite on a smooth seam; their difference tells the angle of a sharp crease.
      add(row, seam.first, a, 0.0, weight * element * place.into_first);
      add(row, seam.second, b, 0.0, (sharp ? -weight : weight) * element * place.into_second);
    } else {
      add(row, seam.first, a, weight, Vec2::Zero());
      add(row, seam.second, b, -weight, Vec2::Zero());
    }
  }
  return row;
}

}  // namespace

SeamRows seam_rows(const Seam& seam, const std::vector<const ShellModel*>& shells) {
  const ShellModel &a = *shells[seam.first], &b = *shells[seam.second];
  const double element = std::max(a.spacing, b.spacing);
  const bool clamped = seam.join == Join::kClamped;
  const std::vector<char> none(seam.places.size(), 0);
  SeamRows out;
  std::vector<PlaceFunctions> of_a, of_b;
  for (const SeamPlace& place : seam.places)
    of_a.push_back({shell_functions(a, place.first)}), of_b.push_back({shell_functions(b, place.second)});
  for (const Hat& hat : hats_along(seam, kTieSpacing * element, none, none)) {
    TermMap position = weighed(seam, hat, of_a, of_b, element, false);
    close_gap(position, shells);
    out.ties.push_back(listed(position)), out.of_ties.push_back({-1, false, hat});
    if (!clamped) continue;
    TermMap slope = weighed(seam, hat, of_a, of_b, element, true);
    if (seam.smooth) close_gap(slope, shells);
    (seam.smooth ? out.ties : out.creases).push_back(listed(slope));
    (seam.smooth ? out.of_ties : out.of_creases).push_back({-1, true, hat});
  }
  return out;
}

namespace {

// [axis][slot]: 1 where a support holds the slot along this axis, but not along all of them.
std::array<std::vector<char>, 3> fixed_along_axes(const ShellModel& m) {
  std::array<std::vector<char>, 3> fixed;
  for (int d = 0; d < 3; ++d) {
    fixed[d].assign(m.tables.component_stride, 0);
    for (const int slot : m.constraints.held[d]) fixed[d][slot] = m.held[slot] == 0;
  }
  return fixed;
}

}  // namespace

// The matrix G M^-1 G^T of the rows for each axis, factorised, with the inverse masses of which it is made.
struct SeamTies::Solver {
  int released = 0;                                      // supports that are released
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
                   const std::vector<const ShellModel*>& shells)
    : SeamTies({std::move(rows), std::move(creases), {}, {}}, {}, shells) {}

SeamTies::SeamTies(SeamRows rows, const std::vector<Seam>& seams, const std::vector<const ShellModel*>& shells) {
  for (const ShellModel* m : shells) fixed_.push_back(fixed_along_axes(*m));
  for (auto& terms : rows.ties) rows_.push_back(row_of(std::move(terms), shells));
  for (auto& terms : rows.creases) creases_.push_back(row_of(std::move(terms), shells));
  for (std::size_t k = 0; k < rows.of_ties.size(); ++k) rows_[k].origin = std::move(rows.of_ties[k]);
  for (std::size_t k = 0; k < rows.of_creases.size(); ++k) creases_[k].origin = std::move(rows.of_creases[k]);
  for (const Seam& seam : seams) places_.emplace_back(seam);
}

SeamTies::Row SeamTies::renewed(const Seam& seam, const std::vector<ShellRef>& shells, RowOrigin origin,
                                const Substitute& independent) const {
  const TiePlaces& places = places_[origin.seam];
  const std::vector<const ShellModel*> models = [&] {
    std::vector<const ShellModel*> out;
    for (const ShellRef& r : shells) out.push_back(r.model);
    return out;
  }();
  std::map<int, PlaceFunctions> of_a, of_b;
  bool bends = true;
  for (const int i : origin.hat.places) {
    of_a[i] = places.at(seam, models, i, true), of_b[i] = places.at(seam, models, i, false);
    bends = bends && of_a[i].bends != 0 && of_b[i].bends != 0;
  }
  Row out;
  out.origin = std::move(origin);
  if (out.origin.slope && !bends) return out;  // nothing there has a slope of its own
  const double element = std::max(models[seam.first]->spacing, models[seam.second]->spacing);
  TermMap row;
  for (const WeightedSlot& t :
       independent(listed(weighed(seam, out.origin.hat, of_a, of_b, element, out.origin.slope))))
    row[{t.shell, t.slot}] += t.weight;
  double sum = 0.0;  // of round-off, and of what `independent` leaves out
  for (const auto& [at, weight] : row) sum += weight;
  for (auto& [at, weight] : row) weight -= sum / static_cast<double>(row.size());
  const auto present = [&](const std::pair<int, int>& at) { return shells[at.first].state->position(at.second); };
  if (!out.origin.slope || seam.smooth) close_gap(row, kMostRenewed, present);
  out.terms = listed(row);
  for (const WeightedSlot& t : out.terms) out.rest += t.weight * present({t.shell, t.slot});
  return out;
}

void SeamTies::renew_kind(const Seam& seam, const std::vector<ShellRef>& shells, int number, bool slope,
                          const std::vector<Hat>& hats, const Substitute& independent) {
  std::vector<Row>& rows = slope && !seam.smooth ? creases_ : rows_;
  const auto own = [&](const Row& row) { return row.origin.seam == number && row.origin.slope == slope; };
  std::vector<Row> now;
  for (const Hat& hat : hats) {
    const bool changed =
        std::any_of(hat.places.begin(), hat.places.end(), [&](int place) { return places_[number].changed(place); });
    const auto old =
        std::find_if(rows.begin(), rows.end(), [&](const Row& row) { return own(row) && row.origin.hat.same_as(hat); });
    now.push_back(old != rows.end() && !changed ? *old : renewed(seam, shells, {number, slope, hat}, independent));
    if (now.back().terms.empty()) now.pop_back();
  }
  std::erase_if(rows, own);
  rows.insert(rows.end(), now.begin(), now.end());
}

bool SeamTies::renew(const std::vector<Seam>& seams, const std::vector<ShellRef>& shells, const std::vector<int>& first,
                     const Substitute& independent) {
  bool any = false;
  for (int k = 0; k < static_cast<int>(places_.size()); ++k) {
    const Seam& seam = seams[k];
    if (!seam.trimmed() || !places_[k].look(seam, shells, first)) continue;
    const double element = std::max(shells[seam.first].model->spacing, shells[seam.second].model->spacing);
    const std::vector<Hat> hats = hats_along(seam, kTieSpacing * element, places_[k].apart(), places_[k].detached());
    renew_kind(seam, shells, k, false, hats, independent);
    if (seam.join == Join::kClamped) renew_kind(seam, shells, k, true, hats, independent);
    any = true;
  }
  if (any) solver_.reset(), cracked_ = true;
  return any;
}

void SeamTies::check() const {
  for (const auto* kind : {&rows_, &creases_})
    for (const Row& row : *kind)
      for (const WeightedSlot& t : row.terms)
        if (t.shell < 0 || t.shell >= static_cast<int>(fixed_.size()) || t.slot < 0 ||
            t.slot >= static_cast<int>(fixed_[t.shell][0].size()))
          throw Error(Exit::kBadInput, "bad_checkpoint", "a tie names a control point that is none");
}

const SeamTies::Solver& SeamTies::solver(const std::vector<ShellRef>& shells) {
  const auto inverse_mass = [&](const std::pair<int, int>& at) {
    return shells[at.first].state->motion.inverse_mass[at.second];
  };
  int released = 0;
  for (const ShellRef& r : shells) released += r.state->motion.released;
  if (solver_) {
    bool same = solver_->released == released;
    for (std::size_t k = 0; k < solver_->points.size() && same; ++k)
      same = solver_->inverse[k] == inverse_mass(solver_->points[k]);
    if (same) return *solver_;
  }
  auto s = std::make_shared<Solver>();
  s->released = released;
  for (std::size_t k = 0; k < shells.size() && released > 0; ++k) fixed_[k] = fixed_along_axes(*shells[k].model);
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
      s->mobility[d][static_cast<Eigen::Index>(k)] = fixed_[shell][d][slot] && !free(shell) ? 0.0 : s->inverse[k];
    }
    for (int e = 0; e < d && !s->factors[d]; ++e)
      if (s->mobility[e] == s->mobility[d]) s->factors[d] = s->factors[e];
    if (s->factors[d] || s->rows.empty()) continue;
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
    s->response[d] = free;
    if (!s->rows.empty()) {
      const Eigen::MatrixXd held = s->factors[d]->solve(Eigen::MatrixXd(s->weights * free));
      s->response[d] -= s->mobility[d].asDiagonal() * Eigen::MatrixXd(s->weights.transpose() * held);
    }
    s->coupling[d] = s->bends * s->response[d];
  }
  solver_ = s;
  return *solver_;
}

void SeamTies::leave_supports_out(std::vector<char> free) {
  const auto holds = [](const std::vector<char>& slots) {
    return std::find(slots.begin(), slots.end(), 1) != slots.end();
  };
  bool any = false;
  for (std::size_t k = 0; k < free.size() && k < fixed_.size(); ++k)
    any = any || (free[k] && std::any_of(fixed_[k].begin(), fixed_[k].end(), holds));
  if (!any) free.clear();
  if (free == free_) return;
  free_ = std::move(free), solver_.reset();
}

void SeamTies::add_forces(const std::vector<ShellRef>& shells, std::vector<double>& (*field)(ShellState&)) {
  if (rows_.empty()) return;
  const Solver& s = solver(shells);
  if (s.rows.empty()) return;
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
  if (s.rows.empty()) return 0.0;
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
      if (s.mobility[d][k] == 0.0 && s.inverse[k] > 0.0) v[k] = 0.0;  // the kick goes into a support of this axis
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
      if (s.mobility[d][k] > 0.0) {
        const double before = of(state.motion.v, slot);
        lost += 0.5 * impulse[k] * (-before - v[k]);
        of(state.motion.v, slot) = v[k];
      } else {
        lost -= impulse[k] * v[k];
      }
      if (pass && s.mobility[d][k] == 0.0) state.pass_to_supports(slot, d, impulse[k]);
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
    for (int d = 0; d < 3; ++d)
      if (s.mobility[d][k] == 0.0 && s.inverse[k] > 0.0) v(k, d) = 0.0;
  }
  const Eigen::MatrixXd now = s.bends * x, along = now.rowwise().normalized();
  Eigen::MatrixXd given = Eigen::MatrixXd::Zero(bends, 3);  // impulses on creases [N s]
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
    const Eigen::VectorXd impulse = solved(gain, -off);
    for (int d = 0; d < 3; ++d) {
      const Eigen::VectorXd j = along.col(d).cwiseProduct(impulse);
      v.col(d) += s.response[d] * j, given.col(d) += j;
    }
    moved = true;
  }
  if (!moved) return;
  Eigen::MatrixXd impulses = s.bends.transpose() * given;  // with those of ties, on control points
  for (int d = 0; d < 3 && !s.rows.empty(); ++d) {
    const Eigen::VectorXd free = s.mobility[d].cwiseProduct(impulses.col(d));
    const Eigen::VectorXd of_ties = s.weights.transpose() * s.factors[d]->solve(Eigen::VectorXd(s.weights * free));
    impulses.col(d) -= of_ties;
  }
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto& [shell, slot] = s.points[k];
    ShellState& state = *shells[shell].state;
    const Vec3 before = state.velocity(slot);
    for (int d = 0; d < 3; ++d) {
      if (s.mobility[d][k] > 0.0)
        state.add_velocity(slot, (v(k, d) - before[d]) * Vec3::Unit(d));
      else
        state.pass_to_supports(slot, d, impulses(k, d));
    }
  }
}

}  // namespace sunder::shell
