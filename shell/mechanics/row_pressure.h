#pragma once
// Pressure that follows the surface, as fast as the forces of the layers: row by row where nothing is cracked.
#include <vector>

#include "shell/mechanics/point_force.h"

namespace sunder::shell {

/// Overwrites `force` [3][plane] with those of a pressure [Pa] along x_u cross x_v, on its present area, at positions
/// `x` [3][plane]: on what the row kernel sums with the patch's functions, and on the gathered `points` with their own.
/// `weight` [block][lane]: parameter area of the Gauss points [m^2], 0 in padding. The same for any number of threads.
void pressure_forces(const RowTables& t, const std::vector<double>& weight, const std::vector<GatheredPoint>& points,
                     double pressure, const std::vector<double>& x, int threads, RowScratch& scratch,
                     std::vector<double>& force);

}  // namespace sunder::shell
