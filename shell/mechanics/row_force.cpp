#include "shell/mechanics/row_force.h"

#include <algorithm>

#include "shell/mechanics/row_element.h"

namespace sunder::shell {

const double* homogeneous(const RowTables& t, const std::vector<double>& x, RowScratch& scratch) {
  if (!t.rational) return x.data();
  const std::size_t plane = t.plane;
  scratch.weighted.resize(x.size());
  for (int d = 0; d < 3; ++d)
    for (std::size_t i = 0; i < plane; ++i) scratch.weighted[d * plane + i] = x[d * plane + i] * t.weight[i];
  return scratch.weighted.data();
}

void sum_rows(const RowTables& t, const RowScratch& scratch, int threads, std::vector<double>& force) {
  const std::size_t row_size = 3 * static_cast<std::size_t>(t.support()) * t.stride;
  // A control row sums its up to degree + 1 element rows, always lowest first.
#pragma omp parallel for schedule(static) num_threads(threads)
  for (int j = 0; j < t.rows; ++j)
    for (int d = 0; d < 3; ++d) {
      double* o = &force[static_cast<std::size_t>(d) * t.plane + static_cast<std::size_t>(j) * t.stride];
      std::fill(o, o + t.stride, 0.0);
      for (int f = std::max(0, j - t.degree); f <= std::min(t.spans_v - 1, j); ++f) {
        const double* part = &scratch.row_force[row_size * f + ((j - f) * 3 + d) * static_cast<std::size_t>(t.stride)];
        for (int i = 0; i < t.stride; ++i) o[i] += part[i];
      }
      if (t.rational)
        for (int i = 0; i < t.stride; ++i) o[i] *= t.weight[static_cast<std::size_t>(j) * t.stride + i];
    }
}

double row_forces(const RowTables& t, const std::vector<double>& x, bool energy, SurfaceStress stress, int threads,
                  RowScratch& scratch, std::vector<double>& force, RowPlasticity* plastic, RowDamage* damage) {
  const std::size_t row_size = 3 * static_cast<std::size_t>(t.support()) * t.stride;
  scratch.row_force.resize(row_size * t.spans_v);
  scratch.row_energy.resize(t.spans_v);
  const double* positions = homogeneous(t, x, scratch);
  const bool record = stress.values != nullptr;
  const LayerLaw law = plastic && plastic->states  ? LayerLaw::kYields
                       : damage && damage->watched ? damage->heals ? LayerLaw::kWeakens : LayerLaw::kIrreversibleDamage
                                                   : LayerLaw::kElastic;
  const RowFunction row = (t.degree == 2 ? quadratic_row : cubic_row)(t.rational, law, energy, record);
  scratch.row_booked.assign(t.spans_v, 0.0);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (int f = 0; f < t.spans_v; ++f)
    scratch.row_energy[f] =
        row(t, positions, stress, {plastic, damage}, f, &scratch.row_force[row_size * f], scratch.row_booked[f]);
  sum_rows(t, scratch, threads, force);
  double sum = 0.0;
  for (const double e : scratch.row_energy) sum += e;
  double booked = 0.0;
  for (const double b : scratch.row_booked) booked += b;
  if (law == LayerLaw::kYields) plastic->dissipated += booked;
  if (law == LayerLaw::kWeakens) damage->healed += booked;
  if (law == LayerLaw::kIrreversibleDamage) damage->dissipated += booked;
  return energy ? sum : 0.0;
}

}  // namespace sunder::shell
