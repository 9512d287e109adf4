#pragma once
// Internal forces of the uncracked part of a patch, row by row of elements.
#include <vector>

#include "shell/mechanics/layers.h"

namespace sunder::shell {

/// Buffers of the kernel, reused: a substep allocates nothing.
struct RowScratch {
  std::vector<double> row_force;               // [span along v][control row 0..degree][x y z][stride]
  std::vector<double> row_energy, row_booked;  // [span along v] [J]; booked: by plastic flow, damage or healing
  std::vector<double> weighted;                // positions times weights of rational patches
};

/// Running mean of the stress of both faces, [block][6][lane]: 11 22 12 at -thickness/2, then at +thickness/2. It is
/// the second Piola-Kirchhoff stress in the parameters of the patch, which are lengths: [Pa] for small strain. For
/// layers that yield it is the true stress.
struct SurfaceStress {
  std::vector<double>* values = nullptr;       // null: not recorded
  double share = 1.0;                          // of the new value in the mean
  const std::vector<double>* least = nullptr;  // [block], least strength [Pa]; null: `over` is not filled
  std::vector<char>* over = nullptr;           // out, [block]: 0 where no recorded tension is above `least`
};

/// Upper bound of the principal stresses: sqrt(a^2 + b^2) <= |a| + |b| avoids the root.
template <class T>
T most_tension(const T& s11, const T& s22, const T& s12) {
  return select(s11 > s22, s11, s22) + select(s12 > -s12, s12, -s12);
}
constexpr double kSurelyBelow = 1.0 - 1e-12;  // share of the strength; a bound below it is surely below the strength

/// What either kernel is asked for.
struct ForceCall {
  const std::vector<double>& x;  // positions [m]
  bool energy = false;
  SurfaceStress stress{};
  int threads = 1;
};

/// Positions times weights, in `scratch`; on patches that are not rational `x` itself.
const double* homogeneous(const RowTables& t, const std::vector<double>& x, RowScratch& scratch);
/// Overwrites `force` with the sum of scratch.row_force, times weights on rational patches. The result does not depend
/// on the number of threads.
void sum_rows(const RowTables& t, const RowScratch& scratch, int threads, std::vector<double>& force);

/// Overwrites `force` [N] with -dW/dx at the positions x, both [component][slot] with the component stride of the
/// tables. Returns the elastic energy [J] if `energy`, else 0; it includes plastic work that is not booked because
/// states do not advance. Sums have a fixed order, so the result does not depend on the number of threads.
double row_forces(const RowTables& t, const ForceCall& call, const LayerMemory& memory, RowScratch& scratch,
                  std::vector<double>& force);

}  // namespace sunder::shell
