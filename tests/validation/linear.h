#pragma once
// Small motions of joined shells: stiffness by differences of the solver's forces.
#include <vector>

#include "tests/shell/stitched.h"

namespace sunder::validation {

/// Displacements of all control points [m], by shell: [3][component stride], as in the solver.
using Displacement = std::vector<std::vector<double>>;

struct Linear {
  Displacement under_load;          // under the models' own loads
  std::vector<double> frequencies;  // [rad/s], ascending
};

/// Returns the `modes` lowest frequencies, and the displacement under the loads. Throws Error where supports leave a
/// rigid motion free.
Linear linear_response(shell::Stitched& s, int modes);

}  // namespace sunder::validation
