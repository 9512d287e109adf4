#pragma once
// A set of bodies that is read in every window. A sorted vector, because a tree would cost a cache miss for each body.
#include <algorithm>
#include <cstddef>
#include <vector>

#include "coupler/core/body.h"

namespace sunder {

/// A set of ids, read in ascending order.
class BodyIds {
 public:
  /// Adds an id; false where the set holds it already. Constant time for an id above all others, as newborn bodies
  /// have.
  bool insert(BodyId id) {
    if (ids_.empty() || ids_.back() < id) {
      ids_.push_back(id);
      return true;
    }
    const auto at = std::lower_bound(ids_.begin(), ids_.end(), id);
    if (*at == id) return false;
    ids_.insert(at, id);
    return true;
  }
  bool contains(BodyId id) const { return std::binary_search(ids_.begin(), ids_.end(), id); }
  void clear() { ids_.clear(); }
  std::size_t size() const { return ids_.size(); }
  auto begin() const { return ids_.begin(); }
  auto end() const { return ids_.end(); }

 private:
  std::vector<BodyId> ids_;
};

}  // namespace sunder
