#pragma once
// What the edges of cracks cost by the fracture energy of the material.
#include "shell/fracture/crack_graph.h"
#include "shell/solver/model.h"

namespace sunder::shell {

/// Fracture energy at a point of the patch, for a tip at rest [J/m^2]: the material's, scaled by the square of the
/// local strength factor.
double fracture_energy_at(const ShellModel& model, const Vec2& p);

/// Returns the energy [J] that an edge costs: its area within the patch times the fracture energy at the speed at which
/// it ran (CrackEdge::resistance).
double edge_cost(const ShellModel& model, const CrackEdge& edge);

/// Length [m] at which a crack divides under the strength of its material, the mirror of a fracture face: drive E G_f /
/// (kMirrorIntensity strength)^2. `drive` is the energy release [G_f] above which a tip divides. 0 without strength.
double mirror_length(const ShellMaterial& material, double drive);

}  // namespace sunder::shell
