#pragma once
// Prescribed cuts of a scene, as polylines.
#include <string>

#include "coupler/scene/load.h"
#include "shell/solver/cracking/crack_rules.h"

namespace sunder::shell {

/// `field` is that of the cut. Throws Error where it leaves the parameter domain, has a segment without length, or
/// crosses or touches itself.
PrescribedCut make_cut(const scene::LoadedScene& scene, const proto::Cut& cut, const ShellModel& model,
                       const std::string& field);

/// What lies on edges opens `seamed` ones (EdgeBits); along clamped ones it is a cut as near to them as cracks run.
/// Throws Error where it lies on another edge: there is nothing to part. `field` is that of the cut.
void settle_edges(const scene::LoadedScene& scene, const ShellModel& model, int seamed, const std::string& field,
                  PrescribedCut& cut);

}  // namespace sunder::shell
