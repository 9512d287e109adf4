#pragma once
// Values of a scene that look as if they were given in another unit.
#include <string>
#include <vector>

#include "scene.pb.h"

namespace sunder::scene {

/// Returns a sentence for each such value: field, value, and what it would be. None is an error by itself.
std::vector<std::string> unit_warnings(const proto::Scene& scene);

}  // namespace sunder::scene
