#pragma once
// Floating-point operations of the kernels. Those of the section are counted by running its formulas; contractions over
// shape functions have the counts of their sums.
#include "shell/mechanics/row_tables.h"

namespace sunder::shell {

/// Floating-point operations of a Gauss point in the row kernel near rest, with its share of the contractions along v,
/// which the points of a row have in common. Layers without memory; a multiply-add counts as two.
double operations_of_row_point(const RowTables& t);
/// The same of a gathered point with `functions` shape functions.
double operations_of_gathered_point(const RowTables& t, std::size_t functions);

}  // namespace sunder::shell
