#pragma once
// Soft bodies against rigid ones.
#include <vector>

#include "shell/contact/proxy.h"
#include "shell/soft/soft_state.h"

namespace sunder::shell {

/// Between `to_grid` and `from_grid`: impulses on grid nodes where points of the surface would be inside a body at the
/// end of the step, inelastic and with Coulomb's friction, all of them together by projected Gauss-Seidel. Each acts
/// at the surface, on the body and, by the weights there, on the nodes: both pages of the body's ledger close.
/// `friction[group]` [-]. Their work is booked. Returns the number of points that press.
int press_on_bodies(const SoftModel& model, SoftState& state, std::vector<Proxy>& bodies,
                    const std::vector<double>& friction, double dt);

}  // namespace sunder::shell
