#pragma once
// One gathered point whose layers yield and weaken. gathered_point.h calls these where a point remembers both.
#include "shell/mechanics/gathered_point.h"

namespace sunder::shell {

/// Resultants at the forms `f`; the memory stays as it is.
Resultants<double> ductile_resultants(const RowTables& t, const GatheredPoint& point, const Forms<double>& f,
                                      const PointMemory& memory);
/// Energy of the full material [J]. `retained` gets what the point does not store.
double ductile_energy(const RowTables& t, const GatheredPoint& point, const Forms<double>& f, const PointMemory& memory,
                      double& retained);
/// As settle() of damage without healing, at the forms `f`.
void settle_ductile_damage(const RowTables& t, const GatheredPoint& point, const Forms<double>& f,
                           const PointMemory& memory, PointDamage& damage);
/// As settle() of layers that yield, at the forms `f`. Returns the plastic work [J].
double settle_ductile_flow(const RowTables& t, const GatheredPoint& point, const Forms<double>& f,
                           const PointMemory& memory);

}  // namespace sunder::shell
