#pragma once
// Where the thousands of small messages of a window live: made, and gone, together.
#include <algorithm>
#include <bit>
#include <memory>
#include <optional>

#include <google/protobuf/arena.h>

namespace sunder::link {

/// An arena that is used again and again, in one block that grows to what the largest so far took.
class MessageMemory {
 public:
  /// Ends what was made before.
  google::protobuf::Arena& fresh() {
    const std::size_t taken = arena_ ? static_cast<std::size_t>(arena_->SpaceAllocated()) : kFirst;
    if (arena_ && taken <= size_) {
      arena_->Reset();
      return *arena_;
    }
    arena_.reset();  // before its block
    size_ = std::min(std::bit_ceil(taken), kMost);
    block_ = std::make_unique_for_overwrite<char[]>(size_);
    google::protobuf::ArenaOptions options;
    options.initial_block = block_.get(), options.initial_block_size = size_;
    return arena_.emplace(options);
  }

 private:
  static constexpr std::size_t kFirst = 4096, kMost = std::size_t{1} << 24;  // [bytes]
  std::size_t size_ = 0;
  std::unique_ptr<char[]> block_;
  std::optional<google::protobuf::Arena> arena_;
};

}  // namespace sunder::link
