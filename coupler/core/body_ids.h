#pragma once
// A set of bodies that is walked through every window: in one piece of memory, where a tree is a cache miss a body.
#include <algorithm>
#include <cstddef>
#include <vector>

#include "coupler/core/body.h"

namespace sunder {

/// Identities in rising order.
class BodyIds {
 public:
  /// False where it is there already. Cheap for those that come in rising order, as newborn bodies do.
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
