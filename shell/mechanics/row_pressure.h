#pragma once
// Pressure that follows the surface: row by row on the uncut part, point by point at gathered points.
#include <vector>

#include "shell/mechanics/point_force.h"

namespace sunder::shell {

/// Overwrites `force` [N] with the forces of a pressure [Pa] along x_u cross x_v on the present area, at positions `x`
/// [m]. Points of the row kernel use the functions of the patch, gathered `points` their own. `weight` [block][lane] is
/// the parameter area of the Gauss points [m^2], 0 in padding. The result does not depend on the number of threads.
void pressure_forces(const RowTables& t, const std::vector<double>& weight, const std::vector<GatheredPoint>& points,
                     double pressure, const std::vector<double>& x, int threads, RowScratch& scratch,
                     std::vector<double>& force);

}  // namespace sunder::shell
