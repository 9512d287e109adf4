#pragma once
// Surfaces of pieces that ties join: stiffness, lumped mass and ties as one linear system.
#include <memory>
#include <string>
#include <vector>

#include <Eigen/SparseCore>

#include "shell/geometry/trim_seams.h"
#include "shell/solver/model.h"
#include "shell/solver/statics/tangent.h"
#include "tests/validation/cases.h"

namespace sunder::validation {

constexpr int kTiedModes = 4;  // frequencies that are compared

/// A surface in pieces, one patch each, whose parameters are lengths.
struct Pieces {
  std::vector<shell::ShellModel> models;
  std::vector<shell::Patch> patches;  // before trims move control points beside them
  shell::Stitches stitches;

  std::vector<const shell::ShellModel*> all() const;
  std::vector<shell::BorderedPatch> bordered() const;
  /// Finds where borders meet, to 1e-7 m.
  void find_seams();
};

/// The system of all pieces. Creases keep positions only.
class TiedSystem {
 public:
  explicit TiedSystem(const Pieces& pieces);
  ~TiedSystem();

  int degree(int shell, int slot, int axis) const;
  int count() const { return count_; }
  const Eigen::VectorXd& mass() const { return mass_; }
  const Eigen::VectorXd& load() const { return load_; }
  /// Small displacements under loads; `held` [1/s^2] is stiffness in proportion to the mass, which holds rigid motions.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& loads, double held);
  /// Lowest frequencies above rigid motions [Hz], by Rayleigh's quotient with the consistent mass (subspace iteration).
  std::vector<double> frequencies(double held, int rigid);
  /// Displacement of a place of a shell along an axis [m].
  double value(const Eigen::VectorXd& u, int shell, const Vec2& at, int axis) const;

 private:
  void factorise(double held);
  double consistent(const Eigen::VectorXd& u) const;

  const Pieces& pieces_;
  std::vector<shell::FreeDegrees> free_;
  std::vector<int> first_;
  int count_ = 0, rows_ = 0;
  Eigen::SparseMatrix<double> stiffness_;
  Eigen::VectorXd mass_, load_;
  std::vector<Eigen::Triplet<double>> ties_;
  double held_ = -1.0;
  struct Factors;
  std::unique_ptr<Factors> factors_;
};

/// Stable step of all pieces together, as if free [s].
double step_of(const Pieces& pieces, int threads);

/// Adds rows NAME_frequency_K that compare both systems to 1 %.
void add_frequencies(Report& r, const std::string& name, TiedSystem& tied, TiedSystem& whole, double held, int rigid);

}  // namespace sunder::validation
