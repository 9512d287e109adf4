#include <vector>

#include <gtest/gtest.h>

#include "coupler/core/body_ids.h"

using namespace sunder;

TEST(BodyIds, AreAscendingInAnyOrderOfInsertion) {
  BodyIds ids;
  for (const BodyId id : {7u, 2u, 9u, 4u}) EXPECT_TRUE(ids.insert(id));
  EXPECT_FALSE(ids.insert(4));
  EXPECT_EQ(std::vector<BodyId>(ids.begin(), ids.end()), (std::vector<BodyId>{2, 4, 7, 9}));
  EXPECT_TRUE(ids.contains(9));
  EXPECT_FALSE(ids.contains(3));
  ids.clear();
  EXPECT_FALSE(ids.contains(9));
}
