#pragma once
// What the edges of cracks cost by the fracture energy of the material.
#include "shell/fracture/crack_graph.h"
#include "shell/solver/model.h"

namespace sunder::shell {

/// Returns the energy [J] that an edge costs: its area within the patch times the fracture energy at the speed at which
/// it ran (CrackEdge::resistance). The fracture energy is scaled by the square of the local strength factor.
double edge_cost(const ShellModel& model, const CrackEdge& edge);

}  // namespace sunder::shell
