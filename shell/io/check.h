#pragma once
// What a scene will cost before it is run.
#include <string>

#include "shell/io/build.h"

namespace sunder::shell {

/// Control points, layer points, stable step, substeps, minutes, memory, and what the spacing means for
/// the fracture energy. Throws Error at the scene's place where the window is shorter than the stable step.
std::string check_report(const scene::LoadedScene& scene, const RunSetup& setup);

/// Its part about soft bodies, their cost measured now.
std::string soft_report(const scene::LoadedScene& scene, const RunSetup& setup);

}  // namespace sunder::shell
