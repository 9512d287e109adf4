#pragma once
// Prescribed cuts of a scene, as polylines.
#include <string>
#include <vector>

#include "coupler/scene/load.h"
#include "shell/solver/model.h"

namespace sunder::shell {

/// A segment that lies on an edge of the patch.
struct EdgeCut {
  int edge = 0;                 // EdgeBit
  double from = 0.0, to = 0.0;  // shares of the edge, `from` the smaller
};

struct PrescribedCut {
  std::vector<std::vector<Vec2>> lines;  // each closed where the last point is exactly the first
  std::vector<EdgeCut> on_edges;
  double time = 0.0;  // [s]
};

/// `field` is that of the cut. Throws Error where it leaves the parameter domain, has a segment without length, or
/// crosses or touches itself.
PrescribedCut make_cut(const scene::LoadedScene& scene, const proto::Cut& cut, const ShellModel& model,
                       const std::string& field);

/// What lies on edges opens `seamed` ones (EdgeBits); along clamped ones it is a cut as near to them as cracks run.
/// Throws Error where it lies on another edge: there is nothing to part. `field` is that of the cut.
void settle_edges(const scene::LoadedScene& scene, const ShellModel& model, int seamed, const std::string& field,
                  PrescribedCut& cut);

}  // namespace sunder::shell
