#include "shell/fracture/sight.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace sunder::shell {
namespace {

constexpr int kFew = 8;                             // edges, which are looked at sooner than the bins around a point
constexpr int kRemembered = 64;                     // edges that were just looked at
constexpr double kBeyond = 1e-6 + kLargestSupport;  // spacings: what is seen is nearer, whatever the round-off
constexpr double kRoundOff = 1e-12;                 // of areas, in squared spacings

typedef double Eight __attribute__((vector_size(64)));
typedef std::int64_t EightMasks __attribute__((vector_size(64)));

EightMasks near_zero(Eight a, double tiny) { return (a < tiny) & (a > -tiny); }

// A bit for each mask that is set, the first one lowest.
unsigned bits_of(EightMasks masks) {
  typedef std::int8_t Bytes __attribute__((vector_size(8)));
  const auto bytes = std::bit_cast<std::uint64_t>(__builtin_convertvector(masks, Bytes));
  return static_cast<unsigned>((bytes & 0x8040201008040201u) * 0x0101010101010101u >> 56);
}

}  // namespace

Sight::Sight(const ControlGrid& grid, const Vec2& p, int span_u, int span_v)
    : p_(p), column_(span_u + 1 - kReach), row_(span_v + 1 - kReach) {
  static_assert(kReach > kLargestSupport + 1.0);
  unsigned columns = 0;
  for (int i = std::max(0, -column_); i < std::min(kAcross, grid.columns - column_); ++i)
    if (std::abs(grid.offset(p, column_ + i).x()) < kLargestSupport) columns |= 1u << i;
  for (int j = std::max(0, -row_); j < std::min(kAcross, grid.rows - row_); ++j)
    if (std::abs(grid.offset(p, (row_ + j) * grid.columns).y()) < kLargestSupport)
      rows_[j] = static_cast<std::uint16_t>(columns);
}

View Sight::view(const ControlGrid& grid) const {
  View v;
  unsigned any = 0;
  int low = 0, high = kAcross;  // rows
  for (const unsigned bits : rows_) any |= bits;
  if (any == 0) return v;
  while (rows_[low] == 0) ++low;
  while (rows_[high - 1] == 0) --high;
  const int left = std::countr_zero(any);
  v.columns = std::bit_width(any) - left, v.rows = high - low;
  v.stride = grid.columns, v.first = (row_ + low) * v.stride + column_ + left;
  for (int i = 0; i < v.columns; ++i) v.x[i] = grid.offset(p_, v.first + i).x();
  for (int j = 0; j < v.rows; ++j) {
    v.y[j] = grid.offset(p_, v.first + j * v.stride).y();
    v.seen[j] = static_cast<std::uint16_t>(rows_[low + j] >> left);
  }
  return v;
}

void Sight::update(const ControlGrid& grid, const CrackGraph& cracks, int end) {
  double x[kAcross + 1] = {};  // of the columns
  for (int i = std::max(0, -column_); i < std::min(kAcross, grid.columns - column_); ++i)
    x[i] = (*grid.parameter)[column_ + i].x();
  if (end - known_ <= kFew) {
    for (int e = known_; e < end; ++e) hide(grid, x, cracks.edges()[e]);
  } else {
    const Vec2 reach = kLargestSupport * Vec2(grid.spacing_u, grid.spacing_v);
    std::array<int, kRemembered> met;  // an edge comes once for each of its bins
    met.fill(-1);
    cracks.near_since(p_ - reach, p_ + reach, known_, [&](int e) {
      if (e < end && std::exchange(met[e % kRemembered], e) != e) hide(grid, x, cracks.edges()[e]);
    });
  }
  known_ = std::max(known_, end);
}

void Sight::hide(const ControlGrid& grid, const double* x, const CrackEdge& e) {
  const Vec2 &c = e.long_a, &d = e.long_b, low = c.cwiseMin(d), high = c.cwiseMax(d);
  const Vec2 reach = kBeyond * Vec2(grid.spacing_u, grid.spacing_v);
  if (((low - p_).array() > reach.array()).any() || ((p_ - high).array() > reach.array()).any()) return;
  const bool left = orientation(c, d, p_) >= 0.0;
  const double tiny = kRoundOff * grid.spacing_u * grid.spacing_v;
  Eight columns[2], from_eye[2], from_c[2];
  EightMasks beside[2];
  std::memcpy(columns, x, sizeof(columns));
  for (int h = 0; h < 2; ++h) {
    from_eye[h] = columns[h] - p_.x(), from_c[h] = columns[h] - c.x();
    // both the eye and the control point left or right of the edge
    beside[h] = p_.x() < low.x() ? columns[h] < low.x() : p_.x() > high.x() ? columns[h] > high.x() : EightMasks{};
  }
  for (int j = 0; j < kAcross; ++j) {
    if (rows_[j] == 0) continue;
    const double y = (*grid.parameter)[(row_ + j) * grid.columns].y();
    if (std::max(p_.y(), y) < low.y() || std::min(p_.y(), y) > high.y()) continue;
    unsigned bits = 0, doubtful = 0;
    for (int h = 0; h < 2; ++h) {  // segments_meet, which decides where round-off would
      const Eight side = (d.x() - c.x()) * (y - c.y()) - (d.y() - c.y()) * from_c[h];
      const Eight to_c = from_eye[h] * (c.y() - p_.y()) - (y - p_.y()) * (c.x() - p_.x());
      const Eight to_d = from_eye[h] * (d.y() - p_.y()) - (y - p_.y()) * (d.x() - p_.x());
      const EightMasks other = left ? side < 0.0 : side >= 0.0;
      bits |= bits_of(other & (to_c * to_d <= 0.0) & ~beside[h]) << 8 * h;
      doubtful |= bits_of(near_zero(side, tiny) | near_zero(to_c, tiny) | near_zero(to_d, tiny)) << 8 * h;
    }
    for (doubtful &= rows_[j]; doubtful; doubtful &= doubtful - 1) {
      const unsigned bit = doubtful & -doubtful;
      const Vec2 q(x[std::countr_zero(bit)], y);
      const bool hidden =
          std::max(p_.x(), q.x()) >= low.x() && std::min(p_.x(), q.x()) <= high.x() && segments_meet(p_, q, c, d);
      bits = hidden ? bits | bit : bits & ~bit;
    }
    rows_[j] = static_cast<std::uint16_t>(rows_[j] & ~bits);
  }
}

}  // namespace sunder::shell
