#pragma once
// An unbounded grid that holds nodes only near particles: blocks of 4 x 4 x 4 nodes, found by hashing.
#include <array>
#include <cstdint>
#include <vector>

namespace sunder::shell {

class SparseGrid {
 public:
  static constexpr int kSide = 4, kBlock = kSide * kSide * kSide;

  /// Block of node coordinate i along one axis.
  static int block_of(int i) { return i >> 2; }
  /// Place of the node (i, j, k) within its block.
  static int place_of(int i, int j, int k) { return (((i & 3) * kSide) + (j & 3)) * kSide + (k & 3); }

  /// Removes all blocks and keeps the memory.
  void clear();
  /// Index of a block. A new block is added; indices count from 0 in the order of the calls.
  int block(const std::array<int, 3>& at);
  int nodes() const { return static_cast<int>(blocks_.size()) * kBlock; }

 private:
  void grow();
  std::vector<std::array<int, 3>> blocks_;
  std::vector<int> table_;  // open addressing; -1: empty
  int last_ = -1;           // block of the last call: neighbours come one after the other
};

}  // namespace sunder::shell
