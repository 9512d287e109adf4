#pragma once
// Free displacements of shells that hang together along seams, and the constraints of these seams.
#include <vector>

#include <Eigen/Sparse>

#include "shell/solver/joining/stitching.h"
#include "shell/solver/statics/tangent.h"

namespace sunder::shell {

/// Shells whose equilibrium is found together: one, or several that seams join.
struct JoinedShells {
  std::vector<ShellRef> shells;
  std::vector<int> numbers;              // of each, as `stitching` counts them
  const Stitching* stitching = nullptr;  // null: one shell alone
  std::vector<Vec3> gravity;             // on each [m/s^2]
};

/// Numbers the free displacements of joined shells. Dependent control points have none. A field is
/// [shell][3][component stride]. Two kinds of seams are constraints instead: ties along trims, and creases that keep
/// the length of a weighted sum of positions.
class JoinedDegrees {
 public:
  explicit JoinedDegrees(const JoinedShells& joined);

  int count() const { return count_; }
  std::size_t size() const { return number_.size(); }
  /// Entry of a field at which shell k begins.
  std::size_t first(std::size_t k) const { return first_[k]; }
  /// Of each entry of a field; -1: held, driven or dependent.
  const std::vector<int>& number() const { return number_; }
  /// Free displacements of one shell alone, dependent ones included.
  const FreeDegrees& own(std::size_t k) const { return own_[k]; }
  bool dependent(std::size_t entry) const { return !dependent_.empty() && dependent_[entry] != 0; }
  bool constrained() const { return !rows_.empty(); }

  /// Moves the forces of dependent control points to those that they depend on.
  void hand_over(std::vector<double>& force) const;
  /// Moves masses, weights or stiffnesses, by the shares of the mass.
  void hand_over_mass(std::vector<double>& field) const;
  /// Gives dependent control points the displacements that those they depend on have.
  void follow(std::vector<double>& u) const;
  /// Entries by free displacements, and back; entries without a number get 0.
  Eigen::VectorXd reduced(const std::vector<double>& field) const;
  std::vector<double> expanded(const Eigen::VectorXd& u) const;
  /// The matrix of all shells from those of each shell alone, whose rows are own(k).
  Eigen::SparseMatrix<double> assembled(const std::vector<Eigen::SparseMatrix<double>>& own) const;

  /// Violations of the constraints at positions x, as shares of the length that their control points stand for [-].
  Eigen::VectorXd violations(const std::vector<double>& x) const;
  /// Their derivatives by free displacements [1/m]. The row of a constraint whose direction is held is zero.
  Eigen::SparseMatrix<double> gradients(const std::vector<double>& x) const;
  /// Their second derivatives, times multipliers, in sum.
  Eigen::SparseMatrix<double> curvature(const std::vector<double>& x, const Eigen::VectorXd& multipliers) const;
  /// Adds to a field of forces what constraints with these multipliers do to all entries, held ones too.
  void add_forces(const std::vector<double>& x, const Eigen::VectorXd& multipliers, std::vector<double>& force) const;

 private:
  struct Term {
    std::size_t entry, stride;  // of the x component; the others are a stride further
    double weight;
  };
  struct Dependent {
    std::size_t entry, stride;
    std::vector<Term> on;
    std::vector<double> shares;
  };
  struct Row {
    std::vector<Term> terms;
    int axis;            // of a tie; -1: a crease
    double rest, scale;  // sum along the axis, or length [m]; 1/m
  };
  static Vec3 sum(const Row& row, const std::vector<double>& x);

  std::vector<FreeDegrees> own_;
  std::vector<std::size_t> first_;
  std::vector<int> number_;
  int count_ = 0;
  std::vector<Dependent> dependents_;
  std::vector<char> dependent_;
  std::vector<Row> rows_;
  std::vector<Eigen::SparseMatrix<double>> moves_;  // [shell]: own displacements by free ones; empty: one shell
};

}  // namespace sunder::shell
