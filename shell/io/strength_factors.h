#pragma once
// Local factors of the strength of a shell.
#include <string>
#include <vector>

#include "coupler/scene/load.h"
#include "shell/solver/model.h"

namespace sunder::shell {

/// Returns the strength factor of each Gauss point, [block][lane]: the product of strength_regions and strength_map.
/// The result is empty where the shell has neither. `field` is the shell's field. Throws Error where a region holds no
/// Gauss point, a map cannot be read or has the wrong aspect ratio, or a product is out of bounds.
std::vector<float> strength_factors(const scene::LoadedScene& scene, const proto::Shell& shell, const ShellModel& model,
                                    const std::string& field);

}  // namespace sunder::shell
