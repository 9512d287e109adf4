#include "shell/grid/transfer.h"

#include <cstddef>

#include "shell/grid/stencil.h"

namespace sunder::shell {
namespace {

Stencil stencil(const std::vector<double>& x, std::size_t stride, std::size_t i, double spacing) {
  return Stencil(x[i], x[stride + i], x[2 * stride + i], spacing);
}

template <Transfer kKind>
void through(double spacing, std::size_t stride, const std::vector<double>& mass, const std::vector<double>& x,
             const std::vector<double>& before, int threads, TransferBuffers& b, std::vector<double>& v,
             std::vector<double>& moving, std::vector<double>& affine) {
  b.grid.clear();
  b.block.resize(kBlocks * stride);
  for (std::size_t i = 0; i < stride; ++i)
    if (mass[i] > 0.0) find_blocks(b.grid, stencil(x, stride, i, spacing), &b.block[kBlocks * i]);
  b.momentum.assign(b.grid.nodes(), {});
  if constexpr (kKind == Transfer::kFlip) b.gain.assign(b.grid.nodes(), {});
  for (std::size_t i = 0; i < stride; ++i) {  // one after the other: the sums do not depend on the number of threads
    if (mass[i] == 0.0) continue;
    const double m = mass[i];
    double p[4], gain[4] = {}, slope[9];
    for (int d = 0; d < 3; ++d)
      p[d] = m * v[d * stride + i], gain[d] = m * (v[d * stride + i] - before[d * stride + i]);
    p[3] = m;
    if constexpr (kKind == Transfer::kApic)
      for (int e = 0; e < 9; ++e) slope[e] = m * affine[e * stride + i];
    stencil(x, stride, i, spacing).each(&b.block[kBlocks * i], [&](std::size_t k, double w, const double* offset) {
      if constexpr (kKind == Transfer::kApic)
        for (std::size_t d = 0; d < 3; ++d)
          b.momentum[k][d] +=
              w * (slope[3 * d] * offset[0] + slope[3 * d + 1] * offset[1] + slope[3 * d + 2] * offset[2]);
      for (int d = 0; d < 4; ++d) b.momentum[k][d] += w * p[d];
      if constexpr (kKind == Transfer::kFlip)
        for (int d = 0; d < 4; ++d) b.gain[k][d] += w * gain[d];
    });
  }
  for (std::size_t k = 0; k < b.momentum.size(); ++k) {
    if (b.momentum[k][3] == 0.0) continue;
    const double inverse = 1.0 / b.momentum[k][3];
    for (int d = 0; d < 3; ++d) b.momentum[k][d] *= inverse;  // now a velocity
    if constexpr (kKind == Transfer::kFlip)
      for (int d = 0; d < 3; ++d) b.gain[k][d] *= inverse;
  }
  const double stiffness = 4.0 / (spacing * spacing);  // inverse of the quadratic kernel's second moment
#pragma omp parallel for schedule(static) num_threads(threads)
  for (std::size_t i = 0; i < stride; ++i) {
    if (mass[i] == 0.0) continue;
    double velocity[4] = {}, gain[4] = {}, slope[9] = {};
    stencil(x, stride, i, spacing).each(&b.block[kBlocks * i], [&](std::size_t k, double w, const double* offset) {
      for (int d = 0; d < 4; ++d) velocity[d] += w * b.momentum[k][d];
      if constexpr (kKind == Transfer::kFlip)
        for (int d = 0; d < 4; ++d) gain[d] += w * b.gain[k][d];
      if constexpr (kKind == Transfer::kApic)
        for (int d = 0; d < 3; ++d)
          for (int e = 0; e < 3; ++e) slope[3 * d + e] += w * b.momentum[k][d] * offset[e];
    });
    for (int d = 0; d < 3; ++d) {
      moving[d * stride + i] = velocity[d];
      v[d * stride + i] = kKind == Transfer::kFlip ? before[d * stride + i] + gain[d] : velocity[d];
    }
    if constexpr (kKind == Transfer::kApic)
      for (int e = 0; e < 9; ++e) affine[e * stride + i] = stiffness * slope[e];
  }
}

}  // namespace

void transfer(Transfer kind, double spacing, std::size_t stride, const std::vector<double>& mass,
              const std::vector<double>& x, const std::vector<double>& before, int threads, TransferBuffers& buffers,
              std::vector<double>& v, std::vector<double>& moving, std::vector<double>& affine) {
  if (kind == Transfer::kDirect) return;
  moving.resize(3 * stride);
  if (kind == Transfer::kApic) affine.resize(9 * stride, 0.0);
  const auto run = kind == Transfer::kFlip   ? through<Transfer::kFlip>
                   : kind == Transfer::kApic ? through<Transfer::kApic>
                                             : through<Transfer::kPic>;
  run(spacing, stride, mass, x, before, threads, buffers, v, moving, affine);
}

}  // namespace sunder::shell
