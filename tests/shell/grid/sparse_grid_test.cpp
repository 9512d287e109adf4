#include <array>
#include <map>

#include <gtest/gtest.h>

#include "shell/grid/sparse_grid.h"

using namespace sunder;
using namespace sunder::shell;

TEST(SparseGrid, GivesEachBlockOneIndexBelowZeroToo) {
  SparseGrid grid;
  for (int pass = 0; pass < 2; ++pass) {
    grid.clear();
    std::map<std::array<int, 3>, int> known;
    for (int i = -20; i < 20; i += 3)
      for (int j = -20; j < 20; j += 3)
        for (int k = -20; k < 20; ++k) {
          const std::array<int, 3> at{SparseGrid::block_of(i), SparseGrid::block_of(j), SparseGrid::block_of(k)};
          const int block = grid.block(at);
          const auto [known_block, fresh] = known.try_emplace(at, block);
          EXPECT_EQ(known_block->second, block);
          const int place = SparseGrid::place_of(i, j, k);
          EXPECT_TRUE(place >= 0 && place < SparseGrid::kBlock);
        }
    EXPECT_EQ(grid.nodes(), static_cast<int>(known.size()) * SparseGrid::kBlock);
  }
}
