#pragma once
// Union and find.
#include <algorithm>
#include <numeric>
#include <vector>

namespace sunder::shell {

struct DisjointSets {
  std::vector<int> parent;
  explicit DisjointSets(int n) : parent(n) { std::iota(parent.begin(), parent.end(), 0); }
  int add() {
    parent.push_back(static_cast<int>(parent.size()));
    return parent.back();
  }
  int root(int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  }
  /// Joins the sets of a and b; the lowest of a set is its root. False where they are one already.
  bool join(int a, int b) {
    a = root(a), b = root(b);
    parent[std::max(a, b)] = std::min(a, b);
    return a != b;
  }
};

}  // namespace sunder::shell
