#pragma once
// Prescribed cuts of a scene, as polylines.
#include <string>
#include <vector>

#include "coupler/scene/load.h"
#include "shell/solver/model.h"

namespace sunder::shell {

struct PrescribedCut {
  std::vector<Vec2> points;  // closed where the last is exactly the first
  double time = 0.0;         // [s]
};

/// `field` is that of the cut. Throws Error where it leaves the parameter domain, has a segment without length, or
/// crosses or touches itself.
PrescribedCut make_cut(const scene::LoadedScene& scene, const proto::Cut& cut, const ShellModel& model,
                       const std::string& field);

}  // namespace sunder::shell
