#pragma once
#include "scene.pb.h"

namespace sunder::scene {

/// Fills in what materials with a preset leave out.
void fill_presets(proto::Scene& scene);

}  // namespace sunder::scene
