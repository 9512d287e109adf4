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

}  // namespace sunder::shell
