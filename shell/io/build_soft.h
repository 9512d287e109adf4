#pragma once
// Soft bodies of a scene.
#include <functional>

#include "coupler/scene/load.h"
#include "shell/io/build.h"

namespace sunder::shell {

/// Adds the soft bodies of the scene, with the contact group that `group` gives each name. Shells and bodies are there
/// already: what starts inside one of them, or what contact would not find, is refused. Throws Error with the field.
void build_soft(const scene::LoadedScene& scene, const std::function<std::uint32_t(const std::string&)>& group,
                RunSetup& setup);

}  // namespace sunder::shell
