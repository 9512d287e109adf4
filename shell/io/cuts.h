#pragma once
// Prescribed cuts of a scene, as polylines.
#include <string>
#include <vector>

#include "coupler/scene/load.h"
#include "shell/solver/cracking/crack_rules.h"

namespace sunder::shell {

/// Makes a cut, in pieces where it grows; `field` is its field in the scene. Throws Error where it leaves the parameter
/// domain, has a segment without length, or crosses or touches itself.
std::vector<PrescribedCut> make_cut(const scene::LoadedScene& scene, const proto::Cut& cut, const ShellModel& model,
                                    const std::string& field);

/// A cut through points of the parameter domain, made at `from` [s], or in pieces that grow from then until `until`
/// where that is later.
std::vector<PrescribedCut> cut_along(const ShellModel& model, std::vector<Vec2> points, double from, double until);

/// Decides on segments that lie on edges. On edges with seams (`seamed`, EdgeBits) they open the seam. On clamped edges
/// they become a cut as near to the edge as cracks can run. Throws Error with `field` on other edges, where nothing can
/// part.
void settle_edges(const scene::LoadedScene& scene, const ShellModel& model, int seamed, const std::string& field,
                  PrescribedCut& cut);

}  // namespace sunder::shell
