#pragma once
// Reads faces of STEP and IGES files.
#include "coupler/scene/load.h"
#include "shell/geometry/patch.h"

namespace sunder::shell {

/// Reads the face that `cad` chooses, scaled to metres, where the file places it; it is not refined or posed. The
/// B-spline is exact for planes, quadrics, tori and B-splines; degree 1 is raised to 2. `field` is that of `cad`.
/// Throws Error where the file cannot be read or the face is no such patch, and always in a build without OpenCASCADE.
Patch read_cad(const scene::LoadedScene& scene, const std::string& field, const proto::CadFace& cad);

}  // namespace sunder::shell
