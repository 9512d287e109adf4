#pragma once
// Small motions of shells that hang together: stiffness by differences of the forces that the solver computes.
#include <vector>

#include "tests/shell/stitched.h"

namespace sunder::validation {

/// Displacements of all control points [m], by shell: [3][plane] as the solver has them.
using Displacement = std::vector<std::vector<double>>;

struct Linear {
  Displacement under_load;          // of the models' own loads
  std::vector<double> frequencies;  // [rad/s], rising
};

/// `modes` lowest frequencies, and the answer to the loads. Throws Error where supports leave it free to move.
Linear linear_response(shell::Stitched& s, int modes);

}  // namespace sunder::validation
