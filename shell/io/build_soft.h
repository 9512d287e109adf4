#pragma once
// Soft bodies of a scene.
#include <functional>

#include "coupler/scene/load.h"
#include "shell/io/build.h"

namespace sunder::shell {

/// Adds the soft bodies of the scene to `setup`; `group` maps a name to its contact group. Shells and bodies must be in
/// `setup` already. Throws Error with the field where a body starts inside another one, or is too fast or too large for
/// contact.
void build_soft(const scene::LoadedScene& scene, const std::function<std::uint32_t(const std::string&)>& group,
                RunSetup& setup);

}  // namespace sunder::shell
