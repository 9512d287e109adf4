#pragma once
// One window: joints and the meetings that were found, solved; and where that takes the bodies. Private to the ODE
// adapter.
#include <vector>

#include "rigid/engine/ode_pairs.h"
#include "rigid/engine/ode_solver.h"

namespace sunder::rigid {

/// Every mover as it is after the window (static ones as they were). `ends` are the handbacks of those that move, in
/// their order; a body that nothing pushes has its own to the bit. Joints index the movers; those are not static.
std::vector<RigidBody> take_window(double window_s, const std::vector<Mover>& movers,
                                   const std::vector<const BodyMotion*>& ends, std::vector<Meeting> meetings,
                                   std::vector<SolverJoint> joints);

}  // namespace sunder::rigid
