#pragma once
// Warnings about bodies that sink between Gauss points.
#include <string>
#include <vector>

#include "coupler/core/body.h"
#include "shell/io/shell_setup.h"

namespace sunder::shell {

/// Half of the sides of a box around the body along its axes [m], shortest first; infinite for a half space.
Vec3 half_sides(const RigidBody& body);
/// Largest distance of a point of the shell from its nearest Gauss point, at rest [m].
double farthest_from_samples(const ShellModel& shell);
/// Returns a warning about bodies that sink deep into a shell before one of its Gauss points feels them, or an empty
/// text. It names the one that sinks most for its size, and counts the others. A ball of radius R sinks by
/// R - sqrt(R^2 - d^2), an edge of a right angle by d, where d is the distance above. Told are balls that sink by more
/// than half of the thickness, and other bodies whose shortest half side is less than twice d. Hertz contact acts
/// between samples.
std::string sampling_gap_warning(const std::vector<ShellSetup>& shells, const std::vector<RigidBody>& bodies);

}  // namespace sunder::shell
