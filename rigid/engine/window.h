#pragma once
// Solves the contacts and joints of one window, and moves the bodies. Private to WindowEngine.
#include <functional>
#include <set>
#include <vector>

#include "rigid/engine/pairs.h"
#include "rigid/engine/velocity_solver.h"

namespace sunder::rigid {

/// What a window's contacts and joints do not tell.
struct Beside {
  std::set<BodyId> elsewhere;                // bodies with contacts that the shell process has solved
  std::function<bool(BodyId, BodyId)> pass;  // two bodies that do not collide
};

/// All movers after the window; static ones are unchanged. `ends`: predicted states of the moving ones, in their order.
/// A body without contacts and joints ends in its predicted state, to the bit. Joints name movers by index, none of
/// them static.
std::vector<RigidBody> take_window(VelocitySolver& solver, double window_s, const std::vector<Mover>& movers,
                                   const std::vector<const BodyMotion*>& ends, std::vector<Meeting> meetings,
                                   std::vector<SolverJoint> joints, const Beside& beside);

}  // namespace sunder::rigid
