#pragma once
// Where a scene makes a shell weaker or stronger than its material.
#include <string>
#include <vector>

#include "coupler/scene/load.h"
#include "shell/solver/model.h"

namespace sunder::shell {

/// Factor of the strength of each Gauss point, [block][lane]: the product of strength_regions and strength_map. Empty
/// where the shell has neither. `field` is the shell's. Throws Error where a region holds no Gauss point, a map cannot
/// be read or has not the domain's shape, or a product is out of bounds.
std::vector<float> strength_factors(const scene::LoadedScene& scene, const proto::Shell& shell, const ShellModel& model,
                                    const std::string& field);

}  // namespace sunder::shell
