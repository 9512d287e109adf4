#pragma once
// Trim loops of a scene, as polygons.
#include <string>
#include <vector>

#include "coupler/scene/load.h"
#include "shell/geometry/patch.h"
#include "shell/geometry/trim_loops.h"
#include "shell/io/cad_file.h"

namespace sunder::shell {

/// Makes the trim loops of a shell; `field` is the shell's. The parameters of `patch` are lengths. A curve becomes a
/// polygon that encloses the same area. `of_file`: loops of the shell's CAD face, in the parameters of `patch`. Throws
/// Error where a loop is open, meets itself or another loop, leaves the patch, or is too small.
TrimLoops make_trims(const scene::LoadedScene& scene, const proto::Shell& shell, const Patch& patch,
                     const std::string& field, const std::vector<CadLoop>& of_file = {});

}  // namespace sunder::shell
