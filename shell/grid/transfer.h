#pragma once
// Particle velocities through the background grid and back, the paper's way of moving (its section 4). It is here to be
// compared: what acts on control points directly neither damps nor shifts frequencies, and costs less.
#include <array>
#include <vector>

#include "shell/grid/sparse_grid.h"

namespace sunder::shell {

enum class Transfer {
  kDirect,  // forces act on control points; no grid
  kFlip,    // particles take the change of the grid's velocity, and move with that velocity itself
  kApic,    // particles keep an affine velocity field each (Jiang et al. 2015)
  kPic,     // particles take the grid's velocity: the paper's lines, literally
};

struct TransferBuffers {
  SparseGrid grid;
  // Of each node: momentum and mass, then, for FLIP, what forces added to the momentum.
  std::vector<std::array<double, 4>> momentum, gain;
  std::vector<int> block;  // [particle][8]: those that hold its nodes
};

/// Particle i is at x[d * plane + i]; mass 0: it is not there. `before` are velocities before forces and contact, `v`
/// those after; `v` is replaced by what comes back. `moving` is what positions move with. `affine` [9][plane] is APIC's
/// state [1/s], zero at the start. Total momentum stays, angular momentum with APIC too.
void transfer(Transfer kind, double spacing, std::size_t plane, const std::vector<double>& mass,
              const std::vector<double>& x, const std::vector<double>& before, int threads, TransferBuffers& buffers,
              std::vector<double>& v, std::vector<double>& moving, std::vector<double>& affine);

}  // namespace sunder::shell
