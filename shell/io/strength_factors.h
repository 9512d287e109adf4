#pragma once
// Local factors of the strength of a shell.
#include <string>
#include <vector>

#include "coupler/scene/load.h"
#include "shell/meshes/paint.h"
#include "shell/solver/model.h"

namespace sunder::shell {

/// Returns the strength factor of each Gauss point, [block][lane]: the product of strength_regions, strength_lines
/// (the scene's too), strength_map and `paint` (null: none). The result is empty where the shell has none. `field` is
/// the shell's field.
/// Throws Error where a region or a line of the shell holds no Gauss point, or a line is narrower than an element.
/// Throws it as well for a map that cannot be read or has the wrong aspect ratio, and for a product out of bounds.
std::vector<float> strength_factors(const scene::LoadedScene& scene, const proto::Shell& shell, const ShellModel& model,
                                    const std::string& field, const Paint* paint = nullptr);

/// Throws Error where a line of the scene passes no Gauss point of its shells. `shells` are parts of the scene, in the
/// order of `models`.
void check_space_lines(const scene::LoadedScene& scene, const std::vector<const proto::Shell*>& shells,
                       const std::vector<const ShellModel*>& models);

}  // namespace sunder::shell
