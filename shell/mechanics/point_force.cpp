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

// Sums the points of one chunk in batches. Returns their energy [J] if it is asked for.
double sum_points(const BatchCall& call, BatchFunction sum_batch, const std::vector<GatheredPoint>& points,
                  std::size_t chunk, double& booked) {
  constexpr std::size_t kTurn = kPointRun * kPointChunks;
  call.strips.prepare((points.size() + kTurn - 1) / kTurn * kPointRun);
  double sum = 0.0;
  Batch batch;
  const auto flush = [&] {
    if (batch.count > 0) sum += sum_batch(call, batch, booked);
    batch.count = 0;
  };
  for (std::size_t begin = chunk * kPointRun, number = 0; begin < points.size(); begin += kTurn)
    for (std::size_t i = begin; i < std::min(begin + kPointRun, points.size()); ++i, ++number) {
      if (points[i].in_rows) continue;
      if (points[i].kind == PointKind::kDead) {
        call.strips.drop(number);
        continue;
      }
      batch.index[batch.count] = i, batch.number[batch.count] = number, batch.points[batch.count++] = &points[i];
      if (batch.count == kLanes) flush();
    }
  flush();
  return sum;
}

}  // namespace

double add_point_forces(const RowTables& t, const std::vector<GatheredPoint>& points, const ForceCall& call,
                        const LayerMemory& memory, PointScratch& scratch, std::vector<double>& force,
                        const PointsBeside& beside) {
  if (points.empty() && !beside) return 0.0;
  const std::size_t size = 3 * static_cast<std::size_t>(t.component_stride);
  scratch.force.resize(kPointChunks * size);
  const bool record = call.stress.values != nullptr;
  double flow[kPointChunks] = {};
  const BatchFunction sum_batch = is_ductile(memory) ? ductile_batch(memory, call.energy, record, flow)
                                                     : batch_function(memory, call.energy, record);
  double sums[kPointChunks] = {}, booked[kPointChunks] = {};
#pragma omp parallel for schedule(static, 1) num_threads(std::min(call.threads, kPointChunks))
  for (int c = 0; c < kPointChunks; ++c) {
    double* own = scratch.force.data() + c * size;
    std::fill(own, own + size, 0.0);
    const BatchCall batches{t, call.x.data(), scratch.strips[c], own, call.stress, memory, section_faces(t.layers)};
    sums[c] = sum_points(batches, sum_batch, points, c, booked[c]);
    if (beside) beside(c, kPointChunks, call.x.data(), own);
  }
  double sum = 0.0;
  for (int c = 0; c < kPointChunks; ++c) {
    sum += sums[c];
    if (is_ductile(memory))
      book_ductile_points(memory, booked[c], flow[c]);
    else
      with_layers(memory, [&]<class Law>(Law) { Law::book_points(memory, booked[c]); });
    const double* own = scratch.force.data() + c * size;
    for (std::size_t i = 0; i < size; ++i) force[i] += own[i];
  }
  return sum;
}

}  // namespace sunder::shell
