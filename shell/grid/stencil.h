#pragma once
// The nodes in the support of one particle, and the blocks that hold them.
#include <array>
#include <cstddef>

#include "shell/grid/kernel.h"
#include "shell/grid/sparse_grid.h"

namespace sunder::shell {

constexpr int kBlocks = 8;  // at most, of the 27 nodes of a particle

/// Weights and offsets of one particle's nodes, along each axis.
struct Stencil {
  Weights along[3];
  double from[3][kNodes];  // from the particle to the node [m]
  Stencil(double x, double y, double z, double spacing) {
    const double at[3] = {x / spacing, y / spacing, z / spacing};
    for (int d = 0; d < 3; ++d) {
      along[d] = grid_weights(at[d]);
      for (int k = 0; k < kNodes; ++k) from[d][k] = (along[d].base + k - at[d]) * spacing;
    }
  }
  std::array<int, 3> low() const {
    return {SparseGrid::block_of(along[0].base), SparseGrid::block_of(along[1].base),
            SparseGrid::block_of(along[2].base)};
  }
  /// Calls f(node, weight, offset [m]) for the 27 nodes. `blocks` are those of `find_blocks`.
  template <class F>
  void each(const int* blocks, F&& f) const {
    const std::array<int, 3> first = low();
    for (int a = 0; a < kNodes; ++a)
      for (int b = 0; b < kNodes; ++b) {
        const int i = along[0].base + a, j = along[1].base + b;
        const std::ptrdiff_t at = SparseGrid::block_of(i) - first[0], beside = SparseGrid::block_of(j) - first[1];
        const int* own = blocks + 4 * at + 2 * beside;
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

/// Writes the blocks [kBlocks] that hold the nodes of `s`, and adds new ones to the grid. -1: the block holds none.
inline void find_blocks(SparseGrid& grid, const Stencil& s, int* blocks) {
  const std::array<int, 3> low = s.low();
  bool two[3];
  for (int d = 0; d < 3; ++d) two[d] = SparseGrid::block_of(s.along[d].base + kNodes - 1) > low[d];
  for (int n = 0; n < kBlocks; ++n) {
    const std::array<int, 3> step{n >> 2, (n >> 1) & 1, n & 1};
    const bool there = (!step[0] || two[0]) && (!step[1] || two[1]) && (!step[2] || two[2]);
    blocks[n] = there ? grid.block({low[0] + step[0], low[1] + step[1], low[2] + step[2]}) : -1;
  }
}

}  // namespace sunder::shell
