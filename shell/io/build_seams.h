#pragma once
// Seams of a scene.
#include "coupler/scene/load.h"
#include "shell/io/build.h"
#include "shell/io/cad_parts.h"

namespace sunder::shell {

/// Finds the seams between the shells of `setup`, which are made of `parts`. Throws Error where shells nearly meet, a
/// rule joins shells that do not meet, or a support does not fit.
Stitches make_stitches(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, CadFiles& files,
                       const RunSetup& setup);

/// Numbers of shells that seams join, directly or over others, by the first of each group. A shell that no seam joins
/// is a group of its own.
std::vector<std::vector<int>> joined_groups(const RunSetup& setup);

}  // namespace sunder::shell
