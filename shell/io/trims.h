#pragma once
// Trim loops of a scene, as polygons.
#include <string>

#include "coupler/scene/load.h"
#include "shell/geometry/patch.h"
#include "shell/geometry/trim_loops.h"

namespace sunder::shell {

/// Makes the trim loops of a shell; `field` is the shell's. The parameters of `patch` are lengths. A curve becomes a
/// polygon that encloses the same area. Throws Error where a loop is open, meets itself or another loop, leaves the
/// patch, or is too small.
TrimLoops make_trims(const scene::LoadedScene& scene, const proto::Shell& shell, const Patch& patch,
                     const std::string& field);

}  // namespace sunder::shell
