#pragma once
// Whether cracks have closed a loop, among themselves or with the border: only then is there another piece.
#include "coupler/core/disjoint_sets.h"
#include "shell/fracture/crack_graph.h"

namespace sunder::shell {

class CrackLoops {
 public:
  /// Whether any edge that is new since the last call may have closed a loop in the domain from `low` to `high` [m].
  /// Edges nearer than kLoopMet of `spacing` have met. Never false where one has closed. No edge of an earlier call may
  /// have been taken back.
  bool closed(const CrackGraph& cracks, const Vec2& low, const Vec2& high, double spacing);

 private:
  DisjointSets sets_{1};  // the border, then the edges
};

}  // namespace sunder::shell
