#pragma once
// A grid without bounds that holds nodes only where something is: blocks of 4 x 4 x 4, found by hashing.
#include <array>
#include <cstdint>
#include <vector>

namespace sunder::shell {

class SparseGrid {
 public:
  static constexpr int kSide = 4, kBlock = kSide * kSide * kSide;

  /// Block that node coordinate i lies in, along one axis.
  static int block_of(int i) { return i >> 2; }
  /// Place of the node (i, j, k) within its block.
  static int place_of(int i, int j, int k) { return (((i & 3) * kSide) + (j & 3)) * kSide + (k & 3); }

  /// Forgets all blocks; keeps the memory.
  void clear();
  /// Index of a block, made where it is new; indices count up from 0 in the order of being asked for.
  int block(const std::array<int, 3>& at);
  int nodes() const { return static_cast<int>(blocks_.size()) * kBlock; }

 private:
  void grow();
  std::vector<std::array<int, 3>> blocks_;
  std::vector<int> table_;  // open addressing; -1: empty
  int last_ = -1;           // block asked for last: neighbours come one after the other
};

}  // namespace sunder::shell
