#include "shell/solver/statics/joined.h"

#include <algorithm>

namespace sunder::shell {

namespace {
constexpr double kHeld = 1e-9;  // free share of a constraint's gradient that round-off of positions may leave
}

JoinedDegrees::JoinedDegrees(const JoinedShells& joined) {
  std::size_t size = 0;
  for (const ShellRef& r : joined.shells) {
    first_.push_back(size);
    own_.push_back(free_degrees(*r.model, *r.state));
    size += own_.back().number.size();
  }
  if (!joined.stitching) {
    number_ = own_[0].number, count_ = own_[0].count;
    return;
  }
  std::vector<int> place;  // of each shell of the stitching among the joined ones; -1: it is none of them
  for (std::size_t k = 0; k < joined.numbers.size(); ++k) {
    place.resize(std::max<std::size_t>(place.size(), joined.numbers[k] + 1), -1);
    place[joined.numbers[k]] = static_cast<int>(k);
  }
  const auto has = [&](int shell) { return shell < static_cast<int>(place.size()) && place[shell] >= 0; };
  const auto stride = [&](int shell) -> std::size_t {
    return joined.shells[place[shell]].model->tables.component_stride;
  };
  const auto term = [&](const auto& t) { return Term{first_[place[t.shell]] + t.slot, stride(t.shell), t.weight}; };
  dependent_.assign(size, 0);
  joined.stitching->each_dependent([&](int shell, int slot, const auto& on) {
    if (!has(shell)) return;
    Dependent& d = dependents_.emplace_back(Dependent{first_[place[shell]] + slot, stride(shell), {}, {}});
    for (const auto& t : on) d.on.push_back(term(t)), d.shares.push_back(t.share);
    for (int axis = 0; axis < 3; ++axis) dependent_[d.entry + axis * d.stride] = 1;
  });
  number_.assign(size, -1);
  std::vector<std::size_t> speaks;  // for each own displacement of all shells: the entry that says where it goes
  std::vector<std::size_t> begin;   // of each shell in `speaks`
  for (std::size_t k = 0; k < own_.size(); ++k) {
    const std::size_t from = speaks.size();
    begin.push_back(from);
    std::vector<int> named(own_[k].count, -1);
    speaks.resize(from + own_[k].count, size);
    for (std::size_t i = 0; i < own_[k].number.size(); ++i) {
      const int n = own_[k].number[i];
      if (n < 0) continue;
      const std::size_t entry = first_[k] + i;
      std::size_t& speaker = speaks[from + n];
      if (speaker == size || (dependent_[speaker] && !dependent_[entry])) speaker = entry;
      if (dependent_[entry]) continue;
      if (named[n] < 0) named[n] = count_++;
      number_[entry] = named[n];
    }
  }
  std::vector<const Dependent*> of(size, nullptr);
  for (const Dependent& d : dependents_)
    for (int axis = 0; axis < 3; ++axis) of[d.entry + axis * d.stride] = &d;
  for (std::size_t k = 0; k < own_.size(); ++k) {
    std::vector<Eigen::Triplet<double>> entries;
    for (int n = 0; n < own_[k].count; ++n) {
      const std::size_t entry = speaks[begin[k] + n];
      if (!of[entry]) {
        entries.emplace_back(n, number_[entry], 1.0);
        continue;
      }
      const std::size_t axis = (entry - of[entry]->entry) / of[entry]->stride;
      for (const Term& t : of[entry]->on)
        if (const int to = number_[t.entry + axis * t.stride]; to >= 0) entries.emplace_back(n, to, t.weight);
    }
    moves_.emplace_back(own_[k].count, count_).setFromTriplets(entries.begin(), entries.end());
  }
  const auto scale = [](const std::vector<Term>& terms) {
    double most = 0.0;
    for (const Term& t : terms) most = std::max(most, std::abs(t.weight));
    return most;
  };
  const auto add = [&](const auto& list, const auto& axes, const auto& rest, double length) {
    std::vector<Term> terms;
    for (const auto& t : list) {
      if (!has(t.shell)) return;
      terms.push_back(term(t));
    }
    for (const int axis : axes) {
      const bool free = std::any_of(terms.begin(), terms.end(), [&](const Term& t) {
        for (int d = 0; d < 3; ++d)
          if ((axis < 0 || d == axis) && number_[t.entry + d * t.stride] >= 0) return true;
        return false;
      });
      if (free) rows_.push_back({terms, axis, rest(axis), 1.0 / (length * scale(terms))});
    }
  };
  double spacing = 0.0;
  for (const ShellRef& r : joined.shells) spacing = std::max(spacing, r.model->spacing);
  joined.stitching->each_tied_sum([&](const auto& list, const Vec3& rest) {
    add(
        list, std::array{0, 1, 2}, [&](int axis) { return rest[axis]; }, spacing);
  });
  joined.stitching->each_crease([&](const auto& list, double length) {
    add(
        list, std::array{-1}, [&](int) { return length; }, spacing);
  });
}

void JoinedDegrees::hand_over(std::vector<double>& force) const {
  for (const Dependent& d : dependents_)
    for (int axis = 0; axis < 3; ++axis) {
      double& own = force[d.entry + axis * d.stride];
      for (const Term& t : d.on) force[t.entry + axis * t.stride] += t.weight * own;
      own = 0.0;
    }
}

void JoinedDegrees::hand_over_mass(std::vector<double>& field) const {
  for (const Dependent& d : dependents_)
    for (int axis = 0; axis < 3; ++axis) {
      double& own = field[d.entry + axis * d.stride];
      for (std::size_t k = 0; k < d.on.size(); ++k) field[d.on[k].entry + axis * d.on[k].stride] += d.shares[k] * own;
      own = 0.0;
    }
}

void JoinedDegrees::follow(std::vector<double>& u) const {
  for (const Dependent& d : dependents_)
    for (int axis = 0; axis < 3; ++axis) {
      double sum = 0.0;
      for (const Term& t : d.on) sum += t.weight * u[t.entry + axis * t.stride];
      u[d.entry + axis * d.stride] = sum;
    }
}

Eigen::VectorXd JoinedDegrees::reduced(const std::vector<double>& field) const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(count_);
  for (std::size_t k = 0; k < field.size(); ++k)
    if (number_[k] >= 0) out[number_[k]] = field[k];
  return out;
}

std::vector<double> JoinedDegrees::expanded(const Eigen::VectorXd& u) const {
  std::vector<double> out(number_.size(), 0.0);
  for (std::size_t k = 0; k < out.size(); ++k)
    if (number_[k] >= 0) out[k] = u[number_[k]];
  follow(out);
  return out;
}

Eigen::SparseMatrix<double> JoinedDegrees::assembled(const std::vector<Eigen::SparseMatrix<double>>& own) const {
  if (moves_.empty()) return own[0];
  Eigen::SparseMatrix<double> sum(count_, count_);
  for (std::size_t k = 0; k < own.size(); ++k) {
    const Eigen::SparseMatrix<double> moved = own[k] * moves_[k];
    sum += Eigen::SparseMatrix<double>(moves_[k].transpose() * moved);
  }
  return sum;
}

Vec3 JoinedDegrees::sum(const Row& row, const std::vector<double>& x) {
  Vec3 out = Vec3::Zero();
  for (const Term& t : row.terms)
    for (int d = 0; d < 3; ++d) out[d] += t.weight * x[t.entry + d * t.stride];
  return out;
}

Eigen::VectorXd JoinedDegrees::violations(const std::vector<double>& x) const {
  Eigen::VectorXd out(static_cast<Eigen::Index>(rows_.size()));
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const Vec3 now = sum(rows_[r], x);
    out[static_cast<Eigen::Index>(r)] =
        rows_[r].scale * ((rows_[r].axis < 0 ? now.norm() : now[rows_[r].axis]) - rows_[r].rest);
  }
  return out;
}

Eigen::SparseMatrix<double> JoinedDegrees::gradients(const std::vector<double>& x) const {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const Row& row = rows_[r];
    const Vec3 along = row.axis < 0 ? Vec3(sum(row, x).normalized()) : Vec3(Vec3::Unit(row.axis));
    double whole = 0.0, free = 0.0;
    for (const Term& t : row.terms)
      for (int d = 0; d < 3; ++d) {
        const double square = t.weight * t.weight * along[d] * along[d];
        whole += square, free += number_[t.entry + d * t.stride] >= 0 ? square : 0.0;
      }
    if (free <= kHeld * kHeld * whole) continue;
    for (const Term& t : row.terms)
      for (int d = 0; d < 3; ++d)
        if (const int n = number_[t.entry + d * t.stride]; n >= 0 && along[d] != 0.0)
          entries.emplace_back(static_cast<int>(r), n, row.scale * t.weight * along[d]);
  }
  Eigen::SparseMatrix<double> out(static_cast<Eigen::Index>(rows_.size()), count_);
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

Eigen::SparseMatrix<double> JoinedDegrees::curvature(const std::vector<double>& x,
                                                     const Eigen::VectorXd& multipliers) const {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const Row& row = rows_[r];
    const double factor = multipliers[static_cast<Eigen::Index>(r)] * row.scale;
    if (row.axis >= 0 || factor == 0.0) continue;
    const Vec3 now = sum(row, x), along = now.normalized();
    const Mat3 across = (Mat3::Identity() - along * along.transpose()) / now.norm();
    for (const Term& a : row.terms)
      for (const Term& b : row.terms)
        for (int d = 0; d < 3; ++d)
          for (int e = 0; e < 3; ++e) {
            const int m = number_[a.entry + d * a.stride], n = number_[b.entry + e * b.stride];
            if (m >= 0 && n >= 0) entries.emplace_back(m, n, factor * a.weight * b.weight * across(d, e));
          }
  }
  Eigen::SparseMatrix<double> out(count_, count_);
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

void JoinedDegrees::add_forces(const std::vector<double>& x, const Eigen::VectorXd& multipliers,
                               std::vector<double>& force) const {
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const Row& row = rows_[r];
    const Vec3 along = row.axis < 0 ? Vec3(sum(row, x).normalized()) : Vec3(Vec3::Unit(row.axis));
    const double size = multipliers[static_cast<Eigen::Index>(r)] * row.scale;
    for (const Term& t : row.terms)
      for (int d = 0; d < 3; ++d) force[t.entry + d * t.stride] -= size * t.weight * along[d];
  }
}

}  // namespace sunder::shell
