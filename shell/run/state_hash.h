#pragma once
// SHA-256 over the computed state: equal for two runs exactly when their results are equal to the bit.
#include <string>

#include "shell/run/simulation.h"

namespace sunder::shell {

/// Hashes `before` (the hash of frozen shells), then positions, velocities, fibres, damage and crack edges of shells,
/// soft bodies, and bodies in the order of their ids.
std::string state_hash(const std::string& before, const State& state);

}  // namespace sunder::shell
