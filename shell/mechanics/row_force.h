#pragma once
// Internal forces of the uncracked part of a patch, row by row of elements.
#include <vector>

#include "shell/mechanics/pack.h"
#include "shell/mechanics/plasticity.h"
#include "shell/mechanics/point_damage.h"
#include "shell/mechanics/row_tables.h"

namespace sunder::shell {

/// Buffers that the kernel reuses; nothing is allocated in a substep.
struct RowScratch {
  std::vector<double> row_force;               // [span along v][control row 0..degree][x y z][stride]
  std::vector<double> row_energy, row_booked;  // [span along v]; dissipated by yielding or damage, or healed
  std::vector<double> weighted;                // [3][plane], control points times weights of rational patches
};

/// Stress of both faces, [block][6][lane]: 11 22 12 at -thickness/2, then at +thickness/2; second
/// Piola-Kirchhoff stress in the patch's parameters, which are lengths, so Pa for small strain; of layers that yield
/// the true stress.
struct SurfaceStress {
  std::vector<double>* values = nullptr;       // null: not recorded
  double share = 1.0;                          // new value's share in the running mean
  const std::vector<double>* least = nullptr;  // [block], of the strengths there [Pa]; null: no block is told of
  std::vector<char>* over = nullptr;           // out, [block]: 0 where no tension recorded is above that
};

/// No principal stress is above it: sqrt(a^2 + b^2) <= |a| + |b| spares the root.
template <class T>
T most_tension(const T& s11, const T& s22, const T& s12) {
  return select(s11 > s22, s11, s22) + select(s12 > -s12, s12, -s12);
}
constexpr double kSurelyBelow = 1.0 - 1e-12;  // of the strength: more than round-off below it is surely not over

constexpr int kFormFields = 6;  // first fundamental form 11 22 12, then the second
/// Layers that yield: their states, [block][layer][change 11 22 12, strain][lane], of gathered points as well. Where
/// `advance` the states move on and `dissipated` gains the energy [J] that this took.
struct RowPlasticity {
  Yielding law;
  std::vector<double>* states = nullptr;  // null: nothing yields
  // Where states last moved on: [block][kFormFields][lane], of gathered points as well; the first of them negative
  // where the point did not bear: then the stress before is that now
  std::vector<double>* forms = nullptr;
  bool advance = false;
  double dissipated = 0.0;
};

/// Gauss points that damage may weaken, but no crack has touched. What they remember moves on where stress is recorded.
struct RowDamage {
  const std::vector<char>* watched = nullptr;     // [block][lane]; null: nothing is damaged
  const std::vector<double>* strength = nullptr;  // [block][lane] [Pa]
  const std::vector<int>* point_of = nullptr;     // [block][lane]: index into `points`
  std::vector<PointDamage>* points = nullptr;
  double brittleness = 0.0;               // H of eq. 9
  bool heals = true;                      // else the damage of a layer is its maximum over time
  double healed = 0.0, dissipated = 0.0;  // out, as in DamageLaw [J]
};

/// Positions [3][plane], times weights on rational patches; then they live in `scratch`.
const double* homogeneous(const RowTables& t, const std::vector<double>& x, RowScratch& scratch);
/// Overwrites `force` [3][plane] with the sum of scratch.row_force, times weights on rational patches; the same for any
/// number of threads.
void sum_rows(const RowTables& t, const RowScratch& scratch, int threads, std::vector<double>& force);

/// Adds nothing: overwrites `force` [3][plane] with -dW/dx of the positions `x` [3][plane]. Sums run in
/// a fixed order, so the result does not depend on the number of threads.
/// Returns the elastic energy [J] if `energy`, else 0; with it what plastic flow would take where states do not
/// advance.
double row_forces(const RowTables& t, const std::vector<double>& x, bool energy, SurfaceStress stress, int threads,
                  RowScratch& scratch, std::vector<double>& force, RowPlasticity* plastic = nullptr,
                  RowDamage* damage = nullptr);

}  // namespace sunder::shell
