#pragma once
// Both kernels for layers that yield and weaken. They are compiled apart: what the compiler inlines in the kernels of
// other laws then does not depend on this one.
#include "shell/mechanics/layers_ductile.h"
#include "shell/mechanics/point_batch.h"
#include "shell/mechanics/row_force.h"

namespace sunder::shell {

/// Sums of a row: elastic energy [J], and the energy that its layers booked [J].
struct RowSums;
using RowFunction = RowSums (*)(const RowTables&, const double*, const SurfaceStress&, const LayerMemory&, int,
                                double*);

/// Forces of a row of elements. Rows add the plastic work [J] of states that advance to `flow`, [span along v].
RowFunction ductile_row(const RowTables& t, const LayerMemory& memory, bool energy, bool stress, double* flow);
/// Forces of a batch of gathered points. They add to `flow`, [chunk].
BatchFunction ductile_batch(const LayerMemory& memory, bool energy, bool record, double* flow);

/// Books plastic work, and what damage dissipated or lost as it healed [J].
void book_ductile_rows(const LayerMemory& memory, double damage, double flow);
void book_ductile_points(const LayerMemory& memory, double damage, double flow);

}  // namespace sunder::shell
