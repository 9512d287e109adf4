#pragma once
// Prescribed cuts of a scene, as polylines.
#include <string>
#include <vector>

#include "coupler/scene/load.h"
#include "shell/solver/model.h"

namespace sunder::shell {

/// A segment of a cut on an edge of the patch.
struct EdgeCut {
  int edge = 0;                 // EdgeBit
  double from = 0.0, to = 0.0;  // shares of the edge; from < to
};

/// A prescribed cut, divided into polylines inside the patch and segments on its edges.
struct PrescribedCut {
  std::vector<std::vector<Vec2>> lines;  // closed where the last point equals the first exactly
  std::vector<EdgeCut> on_edges;
  double time = 0.0;  // [s]
};

/// Makes a cut; `field` is its field in the scene. Throws Error where it leaves the parameter domain, has a segment
/// without length, or crosses or touches itself.
PrescribedCut make_cut(const scene::LoadedScene& scene, const proto::Cut& cut, const ShellModel& model,
                       const std::string& field);

/// Decides on segments that lie on edges. On edges with seams (`seamed`, EdgeBits) they open the seam. On clamped edges
/// they become a cut as near to the edge as cracks can run. Throws Error with `field` on other edges, where nothing can
/// part.
void settle_edges(const scene::LoadedScene& scene, const ShellModel& model, int seamed, const std::string& field,
                  PrescribedCut& cut);

}  // namespace sunder::shell
