#pragma once
// Memory for the thousands of small messages of a window, which are made and dropped together.
#include <algorithm>
#include <bit>
#include <cstddef>
#include <memory>
#include <optional>

#include <google/protobuf/arena.h>

namespace sunder::link {

/// A protobuf arena that is reused. Its block grows to the power of two that holds the largest message so far, strings
/// not counted, up to `most` bytes. Memory beyond the block is freed with the message.
class MessageMemory {
 public:
  static constexpr std::size_t kMost = std::size_t{1} << 22;  // [bytes]: a request and reply of some 7,000 bodies
#ifdef __SANITIZE_ADDRESS__
  static constexpr bool kUsedAgain = false;  // so that the sanitizer sees old messages as freed
#else
  static constexpr bool kUsedAgain = true;
#endif
  explicit MessageMemory(std::size_t most = kMost, bool used_again = kUsedAgain)
      : most_(most), used_again_(used_again) {}

  /// The empty arena. Messages made in it before are gone.
  google::protobuf::Arena& fresh() {
    const std::size_t taken = arena_ ? static_cast<std::size_t>(arena_->SpaceAllocated()) : kFirst;
    if (used_again_ && arena_ && (taken <= size_ || size_ == most_)) {
      arena_->Reset();
      return *arena_;
    }
    arena_.reset();  // before its block is freed
    size_ = std::min(std::bit_ceil(taken), most_);
    block_.reset();
    block_ = std::make_unique_for_overwrite<char[]>(size_);
    google::protobuf::ArenaOptions options;
    options.initial_block = block_.get(), options.initial_block_size = size_;
    options.max_block_size = kNext;
    return arena_.emplace(options);
  }

 private:
  static constexpr std::size_t kFirst = 4096;                 // first block [bytes]: holds requests without a list
  static constexpr std::size_t kNext = std::size_t{1} << 20;  // largest further block [bytes]
  std::size_t most_, size_ = 0;
  bool used_again_;
  std::unique_ptr<char[]> block_;
  std::optional<google::protobuf::Arena> arena_;
};

}  // namespace sunder::link
