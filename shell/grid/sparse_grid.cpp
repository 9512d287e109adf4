#include "shell/grid/sparse_grid.h"

namespace sunder::shell {
namespace {

constexpr std::size_t kFirstTable = 1024;  // a power of two

std::size_t hash(const std::array<int, 3>& at) {
  std::uint64_t h = 0;
  for (const int c : at) {  // splitmix
    h += static_cast<std::uint64_t>(static_cast<std::int64_t>(c)) + 0x9e3779b97f4a7c15ULL;
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
    h ^= h >> 27;
  }
  return static_cast<std::size_t>(h);
}

// compiled inline; the comparison of std::array calls memcmp
bool same(const std::array<int, 3>& a, const std::array<int, 3>& b) {
  return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

}  // namespace

void SparseGrid::clear() {
  table_.assign(table_.empty() ? kFirstTable : table_.size(), -1);
  blocks_.clear(), last_ = -1;
}

int SparseGrid::block(const std::array<int, 3>& at) {
  if (last_ >= 0 && same(blocks_[last_], at)) return last_;
  if (2 * (blocks_.size() + 1) > table_.size()) grow();
  const std::size_t mask = table_.size() - 1;
  std::size_t slot = hash(at) & mask;
  while (table_[slot] >= 0 && !same(blocks_[table_[slot]], at)) slot = (slot + 1) & mask;
  if (table_[slot] < 0) {
    table_[slot] = static_cast<int>(blocks_.size());
    blocks_.push_back(at);
  }
  return last_ = table_[slot];
}

void SparseGrid::grow() {
  table_.assign(table_.empty() ? kFirstTable : 2 * table_.size(), -1);
  const std::size_t mask = table_.size() - 1;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    std::size_t slot = hash(blocks_[b]) & mask;
    while (table_[slot] >= 0) slot = (slot + 1) & mask;
    table_[slot] = static_cast<int>(b);
  }
}

}  // namespace sunder::shell
