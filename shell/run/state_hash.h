#pragma once
// SHA-256 over all that a run has computed: what two runs have in common when they are the same to the bit.
#include <string>

#include "shell/run/simulation.h"

namespace sunder::shell {

/// Over `before` (the hash of shells that were frozen), positions, velocities, fibres, damage and crack edges of
/// shells, soft bodies, and bodies in id order.
std::string state_hash(const std::string& before, const State& state);

}  // namespace sunder::shell
