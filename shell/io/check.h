#pragma once
// Reports what a scene will cost, before it runs.
#include <string>

#include "shell/io/build.h"

namespace sunder::shell {

/// Reports control points, layer points, stable step, substeps, minutes, memory, and the fracture energy that the
/// spacing allows. Throws Error at the scene's place where the window is shorter than the stable step.
std::string check_report(const scene::LoadedScene& scene, const RunSetup& setup);

/// The part of the report about soft bodies; their cost is measured now.
std::string soft_report(const scene::LoadedScene& scene, const RunSetup& setup);

}  // namespace sunder::shell
