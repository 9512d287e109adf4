#pragma once
// Grey images over the parameter domain of a patch.
#include <optional>
#include <string>

#include "coupler/scene/load.h"
#include "shell/io/pgm_file.h"

namespace sunder::shell {

/// Reads the image `path` beside the scene, over a domain of `size` [m]; none: of any shape. `field` is that of the
/// map. Throws Error where it cannot be read, or its width over height is not that of the domain within 2 %.
GreyImage read_grey_map(const scene::LoadedScene& scene, const std::string& path, const std::optional<Vec2>& size,
                        const std::string& field);

}  // namespace sunder::shell
