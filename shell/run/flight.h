#pragma once
// Bodies in flight: what they will meet, and windows without a shell.
#include <vector>

#include <Eigen/Geometry>

#include "shell/io/build.h"

namespace sunder::shell {

/// Tests whether the straight path from `position` with `velocity` enters the box, grown by `pad` on all sides, within
/// `time` from now [s]. A start within the grown box counts.
bool meets_box(const Eigen::AlignedBox3d& box, double pad, const Vec3& position, const Vec3& velocity, double time);

/// Tests whether the straight path from `position` with `velocity` comes within `reach` of a point within `time` [s].
bool passes(const Vec3& point, double reach, const Vec3& position, const Vec3& velocity, double time);

/// Returns the length of the next window without a shell [ticks], at least 1. Two bodies that can meet approach by at
/// most kSettleTravel times the least shell thickness, so they do not pass through each other unseen.
std::int64_t rigid_window_ticks(const RunSetup& setup, const std::vector<Proxy>& bodies);

/// Moves the first `count` bodies for a window [s] that begins at `time` [s]: in free fall, or as the scene prescribes.
void free_fall(std::vector<Proxy>& bodies, std::size_t count, const Vec3& gravity, double time, double window);

}  // namespace sunder::shell
