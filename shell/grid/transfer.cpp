#include "shell/grid/transfer.h"

#include <cstddef>

#include "shell/grid/kernel.h"

namespace sunder::shell {
namespace {

constexpr int kBlocks = 8;  // that three nodes a direction can touch

// One particle's nodes: weights, places, and how far off they lie, along each axis.
struct Stencil {
  Weights along[3];
  double from[3][kNodes];  // [m]
  Stencil(const std::vector<double>& x, std::size_t plane, std::size_t i, double spacing) {
    for (int d = 0; d < 3; ++d) {
      const double at = x[d * plane + i] / spacing;
      along[d] = grid_weights(at);
      for (int k = 0; k < kNodes; ++k) from[d][k] = (along[d].base + k - at) * spacing;
    }
  }
  std::array<int, 3> low() const {
    return {SparseGrid::block_of(along[0].base), SparseGrid::block_of(along[1].base),
            SparseGrid::block_of(along[2].base)};
  }
  // f(node, weight, offset) of its 27 nodes, `blocks` as `find_blocks` left them
  template <class F>
  void each(const int* blocks, F&& f) const {
    const std::array<int, 3> first = low();
    for (int a = 0; a < kNodes; ++a)
      for (int b = 0; b < kNodes; ++b) {
        const int i = along[0].base + a, j = along[1].base + b;
        const int* own = blocks + 4 * (SparseGrid::block_of(i) - first[0]) + 2 * (SparseGrid::block_of(j) - first[1]);
        const double ab = along[0].w[a] * along[1].w[b];
        for (int c = 0; c < kNodes; ++c) {
          const int k = along[2].base + c;
          const int block = own[SparseGrid::block_of(k) - first[2]];
          const double offset[3] = {from[0][a], from[1][b], from[2][c]};
          f(static_cast<std::size_t>(block) * SparseGrid::kBlock + SparseGrid::place_of(i, j, k), ab * along[2].w[c],
            offset);
        }
      }
  }
};

void find_blocks(SparseGrid& grid, const Stencil& s, int* blocks) {
  const std::array<int, 3> low = s.low();
  bool two[3];
  for (int d = 0; d < 3; ++d) two[d] = SparseGrid::block_of(s.along[d].base + kNodes - 1) > low[d];
  for (int n = 0; n < kBlocks; ++n) {
    const std::array<int, 3> step{n >> 2, (n >> 1) & 1, n & 1};
    const bool there = (!step[0] || two[0]) && (!step[1] || two[1]) && (!step[2] || two[2]);
    blocks[n] = there ? grid.block({low[0] + step[0], low[1] + step[1], low[2] + step[2]}) : -1;
  }
}

template <Transfer kKind>
void through(double spacing, std::size_t plane, const std::vector<double>& mass, const std::vector<double>& x,
             const std::vector<double>& before, int threads, TransferBuffers& b, std::vector<double>& v,
             std::vector<double>& moving, std::vector<double>& affine) {
  b.grid.clear();
  b.block.resize(kBlocks * plane);
  for (std::size_t i = 0; i < plane; ++i)
    if (mass[i] > 0.0) find_blocks(b.grid, Stencil(x, plane, i, spacing), &b.block[kBlocks * i]);
  b.momentum.assign(b.grid.nodes(), {});
  if constexpr (kKind == Transfer::kFlip) b.gain.assign(b.grid.nodes(), {});
  for (std::size_t i = 0; i < plane; ++i) {  // in order: the sums do not depend on threads
    if (mass[i] == 0.0) continue;
    const double m = mass[i];
    double p[4], gain[4] = {}, slope[9];
    for (int d = 0; d < 3; ++d) p[d] = m * v[d * plane + i], gain[d] = m * (v[d * plane + i] - before[d * plane + i]);
    p[3] = m;
    if constexpr (kKind == Transfer::kApic)
      for (int e = 0; e < 9; ++e) slope[e] = m * affine[e * plane + i];
    Stencil(x, plane, i, spacing).each(&b.block[kBlocks * i], [&](std::size_t k, double w, const double* offset) {
      if constexpr (kKind == Transfer::kApic)
        for (int d = 0; d < 3; ++d)
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
  for (std::size_t i = 0; i < plane; ++i) {
    if (mass[i] == 0.0) continue;
    double velocity[4] = {}, gain[4] = {}, slope[9] = {};
    Stencil(x, plane, i, spacing).each(&b.block[kBlocks * i], [&](std::size_t k, double w, const double* offset) {
      for (int d = 0; d < 4; ++d) velocity[d] += w * b.momentum[k][d];
      if constexpr (kKind == Transfer::kFlip)
        for (int d = 0; d < 4; ++d) gain[d] += w * b.gain[k][d];
      if constexpr (kKind == Transfer::kApic)
        for (int d = 0; d < 3; ++d)
          for (int e = 0; e < 3; ++e) slope[3 * d + e] += w * b.momentum[k][d] * offset[e];
    });
    for (int d = 0; d < 3; ++d) {
      moving[d * plane + i] = velocity[d];
      v[d * plane + i] = kKind == Transfer::kFlip ? before[d * plane + i] + gain[d] : velocity[d];
    }
    if constexpr (kKind == Transfer::kApic)
      for (int e = 0; e < 9; ++e) affine[e * plane + i] = stiffness * slope[e];
  }
}

}  // namespace

void transfer(Transfer kind, double spacing, std::size_t plane, const std::vector<double>& mass,
              const std::vector<double>& x, const std::vector<double>& before, int threads, TransferBuffers& buffers,
              std::vector<double>& v, std::vector<double>& moving, std::vector<double>& affine) {
  if (kind == Transfer::kDirect) return;
  moving.resize(3 * plane);
  affine.resize(9 * plane, 0.0);
  const auto run = kind == Transfer::kFlip   ? through<Transfer::kFlip>
                   : kind == Transfer::kApic ? through<Transfer::kApic>
                                             : through<Transfer::kPic>;
  run(spacing, plane, mass, x, before, threads, buffers, v, moving, affine);
}

}  // namespace sunder::shell
