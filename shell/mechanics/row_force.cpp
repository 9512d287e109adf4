#include "shell/mechanics/row_force.h"

#include <algorithm>

#include "shell/mechanics/ductile_force.h"
#include "shell/mechanics/row_element.h"

namespace sunder::shell {

const double* homogeneous(const RowTables& t, const std::vector<double>& x, RowScratch& scratch) {
  if (!t.rational) return x.data();
  const std::size_t component_stride = t.component_stride;
  scratch.weighted.resize(x.size());
  for (int d = 0; d < 3; ++d)
    for (std::size_t i = 0; i < component_stride; ++i)
      scratch.weighted[d * component_stride + i] = x[d * component_stride + i] * t.weight[i];
  return scratch.weighted.data();
}

void sum_rows(const RowTables& t, const RowScratch& scratch, int threads, std::vector<double>& force) {
  const std::size_t row_size = 3 * static_cast<std::size_t>(t.support()) * t.stride;
  // A control row sums up to degree + 1 element rows, always the lowest first.
#pragma omp parallel for schedule(static) num_threads(threads)
  for (int j = 0; j < t.rows; ++j)
    for (int d = 0; d < 3; ++d) {
      double* o = &force[static_cast<std::size_t>(d) * t.component_stride + static_cast<std::size_t>(j) * t.stride];
      std::fill(o, o + t.stride, 0.0);
      for (int f = std::max(0, j - t.degree); f <= std::min(t.spans_v - 1, j); ++f) {
        const double* part = &scratch.row_force[row_size * f + ((j - f) * 3 + d) * static_cast<std::size_t>(t.stride)];
        for (int i = 0; i < t.stride; ++i) o[i] += part[i];
      }
      if (t.rational)
        for (int i = 0; i < t.stride; ++i) o[i] *= t.weight[static_cast<std::size_t>(j) * t.stride + i];
    }
}

double row_forces(const RowTables& t, const ForceCall& call, const LayerMemory& memory, RowScratch& scratch,
                  std::vector<double>& force) {
  const std::size_t row_size = 3 * static_cast<std::size_t>(t.support()) * t.stride;
  scratch.row_force.resize(row_size * t.spans_v);
  const bool ductile = is_ductile(memory);  // the second half of what is booked is plastic work
  scratch.row_energy.resize(t.spans_v), scratch.row_booked.assign((ductile ? 2 : 1) * t.spans_v, 0.0);
  const double* positions = homogeneous(t, call.x, scratch);
  const bool record = call.stress.values != nullptr;
  const RowFunction row = ductile ? ductile_row(t, memory, call.energy, record, &scratch.row_booked[t.spans_v])
                          : t.varies()
                              ? varying_row(t.degree, memory, call.energy, record)
                              : (t.degree == 2 ? quadratic_row : cubic_row)(t.rational, memory, call.energy, record);
#pragma omp parallel for schedule(static) num_threads(call.threads)
  for (int f = 0; f < t.spans_v; ++f) {
    const RowSums sums = row(t, positions, call.stress, memory, f, &scratch.row_force[row_size * f]);
    scratch.row_energy[f] = sums.energy, scratch.row_booked[f] = sums.booked;
  }
  sum_rows(t, scratch, call.threads, force);
  double sum = 0.0;
  for (const double e : scratch.row_energy) sum += e;
  double booked = 0.0, flow = 0.0;
  for (int f = 0; f < t.spans_v; ++f) booked += scratch.row_booked[f];
  for (int f = 0; f < t.spans_v && ductile; ++f) flow += scratch.row_booked[t.spans_v + f];
  if (ductile)
    book_ductile_rows(memory, booked, flow);
  else
    with_layers(memory, [&]<class Law>(Law) { Law::book_rows(memory, booked); });
  return call.energy ? sum : 0.0;
}

}  // namespace sunder::shell
