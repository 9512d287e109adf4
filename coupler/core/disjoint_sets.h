#pragma once
// Disjoint sets of integers (union-find).
#include <algorithm>
#include <numeric>
#include <vector>

namespace sunder {

/// Sets of the elements 0 to n - 1; at first each element is a set of its own. The root of a set is its lowest element,
/// so the result does not depend on the order of joins.
class DisjointSets {
 public:
  explicit DisjointSets(int n) : parent_(static_cast<std::size_t>(n)) { std::iota(parent_.begin(), parent_.end(), 0); }

  int size() const { return static_cast<int>(parent_.size()); }

  /// Adds an element, as a set of its own, and returns it.
  int add() {
    parent_.push_back(size());
    return parent_.back();
  }

  /// Lowest element of the set that holds `i`. Shortens the path to it (path halving).
  int root(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  /// Joins the sets of `a` and `b`. Returns false where they are one set already.
  bool join(int a, int b) {
    a = root(a), b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

 private:
  std::vector<int> parent_;
};

}  // namespace sunder
