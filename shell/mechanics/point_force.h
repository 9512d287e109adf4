#pragma once
// Internal forces at gathered points.
#include <array>
#include <functional>
#include <vector>

#include "shell/mechanics/point_packs.h"
#include "shell/mechanics/row_force.h"

namespace sunder::shell {

/// Further forces on control points, summed with those of the points. Called once for each chunk, perhaps at the same
/// time. Positions and forces are [component][slot].
using PointsBeside = std::function<void(int chunk, int chunks, const double* x, double* force)>;

/// Force on a control point [N] as the packs sum it: x y z, and a number that nothing uses.
using SlotForce = Pack4;

/// Memory of the kernel, reused.
struct PointScratch {
  std::array<PointPacks, kPointChunks> packs;
  std::vector<SlotForce> force;  // [chunk][slot]
  std::vector<double> beside;    // [chunk][component][slot] [N]
};

/// Adds the forces of the points to `force` [N], [component][slot]. Returns their elastic energy [J] if `energy`.
/// Damage weakens tension by the present stress, and its memory changes where stress is recorded. With healing a
/// damaged point is elastic but softer: its energy is the full one less the retained one, and a crack that opens there
/// dissipates the stored energy. Without healing the energy is that of unloading along the secant, and the rest is
/// dissipated. Layers that yield continue with the states of the rows. Stress is recorded as in
/// row_forces. The result does not depend on the number of threads: a fixed number of chunks is summed in order.
double add_point_forces(const RowTables& t, const std::vector<GatheredPoint>& points, const ForceCall& call,
                        const LayerMemory& memory, PointScratch& scratch, std::vector<double>& force,
                        const PointsBeside& beside = {});

}  // namespace sunder::shell
