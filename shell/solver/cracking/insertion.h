#pragma once
// New crack edges enter the mechanics here, whoever proposed them.
#include "shell/solver/state.h"

namespace sunder::shell {

/// Adds the edge and gives every Gauss point and interlock whose sight it cuts new shape functions.
/// Books the jump of elastic energy. Returns the edge or -1 where it would have no length.
int insert_edge(const ShellModel& model, ShellState& state, int from, int to, int crack, double time, int face,
                bool interlock);

/// An edge from a vertex to a new one at `to`.
struct NewEdge {
  int from;
  Vec2 to;
  int crack, face;
};

/// Adds edges as one event at `time` (of the positions: energies found at one time are kept), but only where that adds
/// no energy: what a crack would have to put in, the shell does not have. Returns the first of them; negative where
/// they were refused, or one would have no length, and all is as before.
int extend_cracks(const ShellModel& model, ShellState& state, const std::vector<NewEdge>& edges, double time,
                  bool interlock, int threads = 1);

/// The Gauss point leaves the row kernel and keeps its functions: those of the patch. Returns its index in
/// state.cracked.gathered; one that has left before stays what it is.
int gather_point(const ShellModel& model, ShellState& state, int block, int lane);

/// The Gauss point may be damaged from now on: it is listed in state.cracked.gathered, and the row kernel goes on
/// summing it.
void watch_point(const ShellModel& model, ShellState& state, int block, int lane);

ControlGrid control_grid(const ShellModel& model);

/// `uses`, a sight of the same point, sees from now on just the control points of these functions.
void note_uses(const ShellModel& model, const std::vector<GatheredFunction>& functions, Sight& uses);

}  // namespace sunder::shell
