#pragma once
// Where the thousands of small messages of a window live: made, and gone, together.
#include <algorithm>
#include <bit>
#include <cstddef>
#include <memory>
#include <optional>

#include <google/protobuf/arena.h>

namespace sunder::link {

/// An arena that is used again and again, in one block: the power of two that holds what the largest so far took, but
/// for its strings. What a larger one than `most` takes beyond its block is given back.
class MessageMemory {
 public:
  static constexpr std::size_t kMost = std::size_t{1} << 22;  // [bytes]: some 7,000 bodies there and back
#ifdef __SANITIZE_ADDRESS__
  static constexpr bool kUsedAgain = false;  // what has ended is seen as freed
#else
  static constexpr bool kUsedAgain = true;
#endif
  explicit MessageMemory(std::size_t most = kMost, bool used_again = kUsedAgain)
      : most_(most), used_again_(used_again) {}

  /// Ends what was made before.
  google::protobuf::Arena& fresh() {
    const std::size_t taken = arena_ ? static_cast<std::size_t>(arena_->SpaceAllocated()) : kFirst;
    if (used_again_ && arena_ && (taken <= size_ || size_ == most_)) {
      arena_->Reset();
      return *arena_;
    }
    arena_.reset();  // before its block
    size_ = std::min(std::bit_ceil(taken), most_);
    block_.reset();
    block_ = std::make_unique_for_overwrite<char[]>(size_);
    google::protobuf::ArenaOptions options;
    options.initial_block = block_.get(), options.initial_block_size = size_;
    options.max_block_size = kNext;
    return arena_.emplace(options);
  }

 private:
  static constexpr std::size_t kFirst = 4096;                 // [bytes]: requests without a list
  static constexpr std::size_t kNext = std::size_t{1} << 20;  // [bytes]: of what is beyond the block, at most
  std::size_t most_, size_ = 0;
  bool used_again_;
  std::unique_ptr<char[]> block_;
  std::optional<google::protobuf::Arena> arena_;
};

}  // namespace sunder::link
