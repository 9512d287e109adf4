#pragma once
// Transfers particle velocities to the background grid and back: the paper's way of moving (section 4). It is here for
// comparison. Forces that act on control points directly neither damp nor shift frequencies, and cost less.
#include <array>
#include <vector>

#include "shell/grid/sparse_grid.h"

namespace sunder::shell {

enum class Transfer {
  kDirect,  // forces act on control points; no grid
  kFlip,    // particles add the change of the grid's velocity to their own, and move with the grid's velocity
  kApic,    // each particle keeps an affine velocity field (Jiang et al. 2015)
  kPic,     // particles take the grid's velocity: the paper's lines, literally
};

struct TransferBuffers {
  SparseGrid grid;
  // Of each node: momentum and mass; for FLIP also the momentum that forces added.
  std::vector<std::array<double, 4>> momentum, gain;
  std::vector<int> block;  // [particle][kBlocks]: blocks of its nodes
};

/// Sends velocities [m/s] through a grid of `spacing` [m]. Arrays are [component][stride]: coordinate d of particle i
/// is x[d * stride + i]. A particle of mass 0 is absent. `before` holds the velocities before forces and contact, `v`
/// those after; `v` becomes the velocity that the grid returns. `moving` becomes the velocity of the positions.
/// `affine` [9][stride] is the state of APIC [1/s], zero at the start; others leave it empty. Momentum is conserved;
/// with APIC angular momentum too.
void transfer(Transfer kind, double spacing, std::size_t stride, const std::vector<double>& mass,
              const std::vector<double>& x, const std::vector<double>& before, int threads, TransferBuffers& buffers,
              std::vector<double>& v, std::vector<double>& moving, std::vector<double>& affine);

}  // namespace sunder::shell
