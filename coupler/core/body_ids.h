#pragma once
// A set of bodies that is walked through every window: in one piece of memory, where a tree is a cache miss a body.
#include <algorithm>
#include <vector>

#include "coupler/core/body.h"

namespace sunder {

/// Identities in rising order.
class BodyIds {
 public:
  /// False where it is there already. Those of newborn bodies come in rising order, at the end.
  bool insert(BodyId id) {
    const auto at = std::lower_bound(ids_.begin(), ids_.end(), id);
    if (at != ids_.end() && *at == id) return false;
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
