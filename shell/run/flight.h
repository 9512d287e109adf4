#pragma once
// Windows without a shell: their length, and the motion of bodies before the engine solves their contacts.
#include <vector>

#include "shell/io/build.h"

namespace sunder::shell {

/// Returns the length of the next window without a shell [ticks], at least 1. Two bodies that can meet approach by at
/// most kSettleTravel times the least shell thickness, so they do not pass through each other unseen.
std::int64_t rigid_window_ticks(const RunSetup& setup, const std::vector<Proxy>& bodies);

/// Moves the first `count` bodies in free fall for a window [s].
void free_fall(std::vector<Proxy>& bodies, std::size_t count, const Vec3& gravity, double window);

}  // namespace sunder::shell
