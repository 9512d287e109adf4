#pragma once
// Turns plain state into bytes and back, for checkpoints. One list of members serves both ways. The format is not for
// other programs: only the build that wrote it can read it.
#include <array>
#include <cstdint>
#include <cstring>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "coupler/core/error.h"
#include "coupler/core/vec.h"

namespace sunder {

/// True for types that hold numbers only: they are copied as they lie in memory.
template <class T>
inline constexpr bool kAsBytes = std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>;
template <class S, int R, int C, int O>
inline constexpr bool kAsBytes<Eigen::Matrix<S, R, C, O, R, C>> = R != Eigen::Dynamic&& C != Eigen::Dynamic;
template <>
inline constexpr bool kAsBytes<Quat> = true;

/// Collects bytes.
class ArchiveWriter {
 public:
  static constexpr bool kReading = false;
  std::string bytes;
  void raw(const void* data, std::size_t size) { bytes.append(static_cast<const char*>(data), size); }
};

/// Reads bytes in the order of writing. Throws Error (bad_checkpoint) where they end too early.
class ArchiveReader {
 public:
  static constexpr bool kReading = true;
  ArchiveReader(const char* data, std::size_t size) : data_(data), left_(size) {}
  void raw(void* to, std::size_t size) {
    if (size > left_) throw Error(Exit::kBadInput, "bad_checkpoint", fmt::format("{} bytes are missing", size - left_));
    std::memcpy(to, data_, size);
    data_ += size, left_ -= size;
  }
  std::size_t left() const { return left_; }

 private:
  const char* data_;
  std::size_t left_;
};

/// Writes or reads one member, by the kind of `a`. A class brings a function `archive(A& a, T& t)` that lists its
/// members with archive_all.
template <class A, class T>
void archive_one(A& a, T& t);

/// Writes or reads members in this order.
template <class A, class... T>
void archive_all(A& a, T&... t) {
  (archive_one(a, t), ...);
}

namespace archive_detail {

// Length of a list, which has `now` entries while it is written. A length that the rest of the bytes cannot hold is
// refused before memory is taken for it.
template <class A>
std::size_t length(A& a, std::size_t now, std::size_t least_bytes_each) {
  std::uint64_t n = now;
  a.raw(&n, sizeof n);
  if constexpr (A::kReading)
    if (n > a.left() / std::max<std::size_t>(1, least_bytes_each))
      throw Error(Exit::kBadInput, "bad_checkpoint", fmt::format("a list of {} entries does not fit in it", n));
  return static_cast<std::size_t>(n);
}

template <class A, class T>
void sequence(A& a, T& list) {
  const std::size_t n = length(a, list.size(), 1);
  if constexpr (A::kReading) list = T(n);
  for (auto& item : list) archive_one(a, item);
}

template <class A, class T>
void one(A& a, std::vector<T>& v) {
  if constexpr (kAsBytes<T>) {
    const std::size_t n = length(a, v.size(), sizeof(T));
    if constexpr (A::kReading) v = std::vector<T>(n);
    if (n > 0) a.raw(static_cast<void*>(v.data()), n * sizeof(T));
  } else {
    sequence(a, v);
  }
}
template <class A, class T>
void one(A& a, std::deque<T>& d) {
  sequence(a, d);
}
template <class A>
void one(A& a, std::string& s) {
  const std::size_t n = length(a, s.size(), 1);
  if constexpr (A::kReading) s.assign(n, '\0');
  if (n > 0) a.raw(s.data(), n);
}
template <class A, class F, class S>
void one(A& a, std::pair<F, S>& p) {
  archive_one(a, p.first), archive_one(a, p.second);
}
template <class A, class K, class V>
void one(A& a, std::map<K, V>& m) {
  std::vector<std::pair<K, V>> list(m.begin(), m.end());
  sequence(a, list);
  if constexpr (A::kReading) m = std::map<K, V>(list.begin(), list.end());
}
template <class A, class K>
void one(A& a, std::set<K>& s) {
  std::vector<K> list(s.begin(), s.end());
  sequence(a, list);
  if constexpr (A::kReading) s = std::set<K>(list.begin(), list.end());
}
template <class A, class T>
void one(A& a, T& t) {
  archive(a, t);
}

}  // namespace archive_detail

template <class A, class T>
void archive_one(A& a, T& t) {
  if constexpr (kAsBytes<T>)
    a.raw(static_cast<void*>(&t), sizeof(T));
  else
    archive_detail::one(a, t);
}

}  // namespace sunder
