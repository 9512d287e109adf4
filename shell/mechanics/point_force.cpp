#include "shell/mechanics/point_force.h"

#include <algorithm>

#include "shell/mechanics/ductile_force.h"
#include "shell/mechanics/point_batch.h"

namespace sunder::shell {
namespace {

BatchFunction batch_function(const LayerMemory& memory, bool energy, bool record) {
  return with_layers(memory, [&]<class Law>(Law) -> BatchFunction {
    if (energy) return record ? sum_batch<true, true, Law> : sum_batch<true, false, Law>;
    return record ? sum_batch<false, true, Law> : sum_batch<false, false, Law>;
  });
}

// Adds the forces that the chunks summed.
void add_chunks(const PointScratch& scratch, std::size_t stride, bool beside, std::vector<double>& force) {
  for (int c = 0; c < kPointChunks; ++c) {
    const SlotForce* own = scratch.force.data() + c * stride;
    for (int i = scratch.packs[c].first_slot(); i < scratch.packs[c].end_slot(); ++i)
      for (std::size_t k = 0; k < 3; ++k) force[k * stride + i] += own[i][k];
    if (!beside) continue;
    const double* other = scratch.beside.data() + 3 * c * stride;
    for (std::size_t i = 0; i < 3 * stride; ++i) force[i] += other[i];
  }
}

}  // namespace

double add_point_forces(const RowTables& t, const std::vector<GatheredPoint>& points, const ForceCall& call,
                        const LayerMemory& memory, PointScratch& scratch, std::vector<double>& force,
                        const PointsBeside& beside) {
  if (points.empty() && !beside) return 0.0;
  const std::size_t stride = t.component_stride;
  scratch.force.resize(kPointChunks * stride);
  if (beside) scratch.beside.resize(kPointChunks * 3 * stride);
  const bool record = call.stress.values != nullptr;
  double flow[kPointChunks] = {};
  const BatchFunction sum_batch = is_ductile(memory) ? ductile_batch(memory, call.energy, record, flow)
                                                     : batch_function(memory, call.energy, record);
  double sums[kPointChunks] = {}, booked[kPointChunks] = {};
#pragma omp parallel for schedule(static, 1) num_threads(std::min(call.threads, kPointChunks))
  for (int c = 0; c < kPointChunks; ++c) {
    PointPacks& packs = scratch.packs[c];
    packs.update(t, points, c);
    SlotForce* const own = scratch.force.data() + c * stride;
    std::fill(own + packs.first_slot(), own + packs.end_slot(), SlotForce{});
    const BatchCall batches{t, call.x.data(), own, call.stress, memory, section_faces(t.layers)};
    double sum = 0.0;
    packs.each([&](const PointPack& p, const PointPack* next) { sum += sum_batch(batches, p, next, booked[c]); });
    sums[c] = sum;
    if (!beside) continue;
    double* const other = scratch.beside.data() + 3 * c * stride;
    std::fill(other, other + 3 * stride, 0.0);
    beside(c, kPointChunks, call.x.data(), other);
  }
  double sum = 0.0;
  for (int c = 0; c < kPointChunks; ++c) {
    sum += sums[c];
    if (is_ductile(memory))
      book_ductile_points(memory, booked[c], flow[c]);
    else
      with_layers(memory, [&]<class Law>(Law) { Law::book_points(memory, booked[c]); });
  }
  add_chunks(scratch, stride, static_cast<bool>(beside), force);
  return sum;
}

}  // namespace sunder::shell
