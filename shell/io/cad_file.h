#pragma once
// Faces of STEP and IGES files.
#include "coupler/scene/load.h"
#include "shell/geometry/patch.h"

namespace sunder::shell {

/// The face that `cad` chooses, scaled, in metres, where the file has it: neither refined nor posed.
/// Its B-spline is exact where the file's surface is a plane, a quadric, a torus or a B-spline; degree 1 is
/// raised to 2. `field` is that of `cad`. Throws Error where the file or the face is no such patch, and always
/// where the build has no OpenCASCADE.
Patch read_cad(const scene::LoadedScene& scene, const std::string& field, const proto::CadFace& cad);

}  // namespace sunder::shell
