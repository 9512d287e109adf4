#include "coupler/core/disjoint_sets.h"

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

using namespace sunder;

TEST(DisjointSets, JoinOnceAndAreNamedByTheirLowestElement) {
  DisjointSets sets(5);
  EXPECT_TRUE(sets.join(4, 2));
  EXPECT_TRUE(sets.join(3, 4));
  EXPECT_FALSE(sets.join(2, 3));
  EXPECT_EQ(sets.root(4), 2);
  EXPECT_EQ(sets.root(3), 2);
  EXPECT_EQ(sets.root(0), 0);
  EXPECT_EQ(sets.add(), 5);
  EXPECT_EQ(sets.root(5), 5);
  EXPECT_TRUE(sets.join(5, 0));
  EXPECT_EQ(sets.root(5), 0);
  EXPECT_EQ(sets.size(), 6);
}

TEST(DisjointSets, AreTheSameForAnyOrderOfJoins) {
  std::mt19937_64 random(4);
  constexpr int kCount = 60;
  std::vector<std::pair<int, int>> joins;
  for (int k = 0; k < 45; ++k) joins.emplace_back(random() % kCount, random() % kCount);
  std::vector<int> first;
  for (int order = 0; order < 10; ++order) {
    DisjointSets sets(kCount);
    for (const auto& [a, b] : joins) sets.join(a, b);
    std::vector<int> roots;
    for (int i = 0; i < kCount; ++i) roots.push_back(sets.root(i));
    if (first.empty()) first = roots;
    EXPECT_EQ(roots, first);
    for (const auto& [a, b] : joins) EXPECT_EQ(roots[a], roots[b]);
    std::shuffle(joins.begin(), joins.end(), random);
  }
  int sets = 0;
  for (int i = 0; i < kCount; ++i) sets += first[i] == i;
  EXPECT_GT(sets, 1);
}
