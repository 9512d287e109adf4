#pragma once
// Places in space on shells, which may be several charts of a mesh or faces of a file: boxes of supports, lines of
// cuts.
#include <vector>

#include "shell/io/build.h"
#include "shell/io/cad_parts.h"

namespace sunder::shell {

/// Throws Error where a box of a support holds nothing, or boxes hold all of a shell of the scene.
void check_boxes(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, const RunSetup& setup);

/// Whether a shell's own stable step is that without supports: where it can crack, where a support is released, and
/// where supports hold all of it, while shells that are joined to it may move.
bool steps_as_if_free(const RunSetup& setup, std::size_t shell);

/// Adds cuts along lines in space to the shells of `setup`. A line is moved to the nearest places of the surface, and
/// divided where it passes from one shell to another. Throws Error where it is far from the surface, jumps or crosses
/// itself.
void add_space_cuts(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, RunSetup& setup);

}  // namespace sunder::shell
