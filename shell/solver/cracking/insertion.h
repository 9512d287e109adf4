#pragma once
// All new crack edges enter the mechanics here, whichever criterion proposes them.
#include "shell/solver/state.h"

namespace sunder::shell {

/// Adds the edge. Every Gauss point and every pair of faces whose visibility it cuts gets new shape functions. Books
/// the change of elastic energy. Returns the edge, or -1 where it would have no length.
int insert_edge(const ShellModel& model, ShellState& state, int from, int to, int crack, double time, int face,
                bool interlock);

/// An edge from a vertex to a new one at `to`.
struct NewEdge {
  int from;
  Vec2 to;
  int crack, face;
  double resistance = 1.0;  // what its area takes, over the fracture energy of the material
};

/// Adds edges as one event, if together they add no energy: a crack cannot put in energy that the shell does not have.
/// `time` [s] is that of the positions; energies found at one time are kept. Returns the first edge, or -1 where they
/// are refused or one would have no length; then nothing has changed.
int extend_cracks(const ShellModel& model, ShellState& state, const std::vector<NewEdge>& edges, double time,
                  bool interlock, int threads = 1);

/// The Gauss point leaves the row kernel and keeps its functions, those of the patch. Returns its index in
/// state.cracked.gathered. A point that was handed off before stays as it is.
int gather_point(const ShellModel& model, ShellState& state, int block, int lane);

/// The Gauss point may be damaged from now on. It is listed in state.cracked.gathered; the row kernel still sums it.
void watch_point(const ShellModel& model, ShellState& state, int block, int lane);

}  // namespace sunder::shell
