#pragma once
// Values of a scene that look as if they were given in another unit.
#include <string>
#include <vector>

#include "coupler/core/error.h"
#include "scene.pb.h"

namespace sunder::scene {

/// Returns a sentence for each such value: field, value, and what it would be. None is an error by itself.
std::vector<std::string> unit_warnings(const proto::Scene& scene);

/// True where a value in a wrong unit can be why a run is refused or stops: a density, a stiffness, a strength, a
/// length, a place, a speed, a step or a window decides it. A name, a support or a place in a patch's parameters does
/// not.
bool may_be_by_units(const Error& error);

}  // namespace sunder::scene
