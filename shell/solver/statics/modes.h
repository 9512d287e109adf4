#pragma once
// Small vibrations of an uncracked shell about its present positions.
#include <functional>
#include <vector>

#include "shell/solver/statics/balance.h"

namespace sunder::shell {

/// One mode of vibration.
struct Mode {
  double eigenvalue = 0.0;    // omega^2 with the lumped mass [1/s^2]; negative: the shell moves away by itself
  double in_run = 0.0;        // frequency with the lumped mass [Hz], as in a run; 0 where the eigenvalue is negative
  double frequency = 0.0;     // the same by Rayleigh's quotient, with the consistent mass [Hz]
  std::vector<double> shape;  // displacement of each slot, [shell][3][component stride] [-]; the largest has length 1
};

/// Modes of a shell.
struct ModeSet {
  std::vector<Mode> modes;  // by eigenvalue, rigid motions left out
  int rigid = 0;            // rigid motions that neither supports nor loads resist
  int unstable = 0;         // modes with a negative eigenvalue
  int degrees = 0;          // free displacements
  double asymmetry = 0.0;   // norm of K - K^T over that of K: of loads that turn with the surface, and of round-off [-]
};

/// Returns the `count` lowest modes of M^-1 K. K is the tangent stiffness at the present positions, symmetrised, and M
/// the lumped mass, as in a run. Lumping makes frequencies too low by (degree + 1)/24 (k h)^2, with k the wave number
/// and h the element. Rayleigh's quotient of the same shape with the consistent mass leaves the error of the stiffness:
/// of fourth order in h for cubic patches, and (k h)^2 / 24 too high for quadratic ones that bend. Damping, gravity and
/// contact do not enter; prestress does. Eigenpairs are found by the method of Lanczos with shift and invert (Spectra).
/// Their number is checked by the inertia of a factorisation (Sylvester). `forces` computes state.motion.force [N].
/// Throws Error (modes) where they do not converge, Error (bad_input) where the shell has cracks or fewer than `count`
/// free displacements.
ModeSet vibration_modes(const ShellModel& model, ShellState& state, int count, const std::function<void()>& forces);

/// The same for shells that seams join, which vibrate together. Dependent control points have no
/// freedom of their own. A stiffness far above that of low modes keeps the constraints of seams.
ModeSet vibration_modes(const JoinedShells& joined, int count, int threads, bool at_equilibrium = true);

/// Modes of the same shells about their present positions with several masses. Stiffness does not depend on mass, so it
/// is found once.
class Vibrations {
 public:
  /// States must outlive it. It leaves gravity and forces that seams bear out.
  Vibrations(const JoinedShells& joined, int threads);
  Vibrations(const Vibrations&) = delete;
  /// Returns the `count` lowest modes with the masses that the states have now.
  ModeSet lowest(int count) const;

 private:
  JoinedShells joined_;
  Balance balance_;
  Eigen::SparseMatrix<double> stiffness_, kept_;
};

}  // namespace sunder::shell
