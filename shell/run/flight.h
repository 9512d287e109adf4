#pragma once
// Windows without a shell: how long they may be, and how bodies move in them before the engine solves their contacts.
#include <vector>

#include "shell/io/build.h"

namespace sunder::shell {

/// Ticks of the next window without a shell. Two bodies that can meet approach by little more than the thickness of
/// the thinnest shell in it, so that they do not pass through one another unseen.
std::int64_t settle_ticks(const RunSetup& setup, const std::vector<Proxy>& bodies);

/// The first `count` bodies fall freely for a window [s].
void fly(std::vector<Proxy>& bodies, std::size_t count, const Vec3& gravity, double window);

}  // namespace sunder::shell
