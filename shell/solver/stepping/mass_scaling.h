#pragma once
// Selective mass scaling: elements that limit the step get mass.
#include <string>
#include <vector>

#include "shell/solver/model.h"

namespace sunder::shell {

/// What mass scaling does to a scene's shells.
struct MassScaling {
  /// A natural frequency of shells that seams join, or of one.
  struct Lowered {
    std::string shells;                                    // "ring.1+ring.2"
    int mode = 0;                                          // from 1, by the frequency without added mass
    double before = 0.0, after = 0.0;                      // [Hz]
    double error() const { return 1.0 - after / before; }  // share by which it is lowered [-]
  };
  double added = 0.0, share = 0.0;             // mass [kg]; over that of these shells and of those joined to them
  double step_before = 0.0, step_after = 0.0;  // stable steps [s]
  double most_added = 0.0, most_error = 0.0;   // bounds [-]
  std::vector<Lowered> modes;

  const Lowered& worst() const;
};

/// Returns the largest eigenvalue of each element's stiffness at rest over its own lumped mass [1/s^2], [row][column];
/// 0 where trims leave nothing of the element. It takes the linear stiffness of the section, by Hooke's law. No
/// eigenvalue of the shell is above the largest of its elements (Irons and Treharne 1971). Elements that are alike to a
/// millionth share their number.
std::vector<double> element_eigenvalues(const ShellModel& model);

/// Gives every element so much mass that its eigenvalue is at most `limit` [1/s^2], and none to elements below it.
/// `own` are the masses of the slots without added mass [kg], as make_shell() makes them. Mass goes to control points
/// as the element's own does. Returns the mass that is added [kg].
double add_mass(ShellModel& model, const std::vector<double>& own, const std::vector<double>& eigenvalues,
                double limit);

}  // namespace sunder::shell
