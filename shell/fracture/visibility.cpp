#include "shell/fracture/visibility.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sunder::shell {
namespace {

constexpr int kFew = 8;                             // edges that are tested one by one, without the bins
constexpr int kRemembered = 64;                     // edges that were tested last
constexpr double kBeyond = 1e-6 + kLargestSupport;  // spacings: visible points are nearer, whatever the round-off
constexpr double kRoundOff = 1e-12;                 // of areas, in squared spacings
constexpr double kLargestUncertainty = 1e-3;        // spacings

typedef double Four __attribute__((vector_size(32)));
typedef std::int64_t FourMasks __attribute__((vector_size(32)));
constexpr int kPacks = 4;

// A bit for each column from `left` to `right`, the first one lowest.
unsigned columns_between(const Four* x, double left, double right) {
  FourMasks bits{};
  for (int k = 0; k < kPacks; ++k) bits |= (x[k] >= left) & (x[k] <= right) & (FourMasks{1, 2, 4, 8} << 4 * k);
  return static_cast<unsigned>(bits[0] | bits[1] | bits[2] | bits[3]);
}

}  // namespace

// Offsets of columns from the point, which rise; infinite where the patch has none.
struct Visibility::Columns {
  Four at[kPacks];
};

Visibility::Columns Visibility::columns(const ControlGrid& grid) const {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  Columns c;
  for (int i = 0; i < 4 * kPacks; ++i)
    c.at[i / 4][i % 4] = column_ + i < 0               ? -kNone
                         : column_ + i >= grid.columns ? kNone
                                                       : (*grid.parameter)[column_ + i].x() - p_.x();
  return c;
}

Visibility::Visibility(const ControlGrid& grid, const Vec2& p, int span_u, int span_v)
    : p_(p), column_(span_u + 1 - kReach), row_(span_v + 1 - kReach) {
  static_assert(kReach > kLargestSupport + 1.0);
  unsigned columns = 0;
  for (int i = std::max(0, -column_); i < std::min(kAcross, grid.columns - column_); ++i)
    if (std::abs(grid.offset(p, column_ + i).x()) < kLargestSupport) columns |= 1u << i;
  for (int j = std::max(0, -row_); j < std::min(kAcross, grid.rows - row_); ++j)
    if (std::abs(grid.offset(p, (row_ + j) * grid.columns).y()) < kLargestSupport)
      rows_[j] = static_cast<std::uint16_t>(columns);
  for (int j = 0; grid.absent && j < kAcross; ++j)
    for (int i = 0; rows_[j] && i < kAcross; ++i)
      if ((rows_[j] >> i & 1u) && (*grid.absent)[(row_ + j) * grid.columns + column_ + i])
        rows_[j] = static_cast<std::uint16_t>(rows_[j] & ~(1u << i));
}

View Visibility::view(const ControlGrid& grid) const {
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

// An edge hides what lies beyond it in the wedge that it fills: three half planes, and of each row of control points
// what is between two ends. Where round-off would decide, segments_meet does.
template <class F>
void Visibility::each_hidden(const ControlGrid& grid, const Columns& x, const CrackEdge& e, F&& callback) const {
  const Vec2 low = e.long_a.cwiseMin(e.long_b) - p_, high = e.long_a.cwiseMax(e.long_b) - p_;
  const Vec2 reach = kBeyond * Vec2(grid.spacing_u, grid.spacing_v);
  if ((low.array() > reach.array()).any() || (-high.array() > reach.array()).any()) return;
  Vec2 a = e.long_a - p_, b = e.long_b - p_;
  double area = a.x() * b.y() - a.y() * b.x();
  if (area < 0.0) std::swap(a, b), area = -area;
  const Vec2 along = b - a;
  // n . w >= 0 of the rays to both ends, >= area of the edge: an end in a row is `at` + `slope` times its y
  const Vec2 normals[3] = {{-a.y(), a.x()}, {b.y(), -b.x()}, {along.y(), -along.x()}};
  const double tiny = kRoundOff * grid.spacing_u * grid.spacing_v;
  double at[3], slope[3], uncertainty = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double over = 1.0 / normals[k].x();
    at[k] = k == 2 ? area * over : 0.0, slope[k] = -normals[k].y() * over;
    uncertainty = std::max(uncertainty, tiny * std::abs(over));
  }
  const bool unsure = !(area > tiny && uncertainty < kLargestUncertainty * grid.spacing_u);
  constexpr double kFar = std::numeric_limits<double>::infinity();
  for (int j = 0; j < kAcross; ++j) {
    if (rows_[j] == 0) continue;
    const double row = (*grid.parameter)[(row_ + j) * grid.columns].y(), y = row - p_.y();
    if (std::max(0.0, y) < low.y() || std::min(0.0, y) > high.y()) continue;
    unsigned hidden = 0, uncertain = rows_[j];
    if (!unsure) {
      double left = -kFar, right = kFar;
      for (int k = 0; k < 3; ++k) {
        const double end = at[k] + slope[k] * y;
        left = normals[k].x() > 0.0 ? std::max(left, end) : left;
        right = normals[k].x() > 0.0 ? right : std::min(right, end);
      }
      if (left - uncertainty > right + uncertainty) continue;
      hidden = columns_between(x.at, left + uncertainty, right - uncertainty);
      uncertain &= columns_between(x.at, left - uncertainty, right + uncertainty) & ~hidden;
    }
    for (; uncertain; uncertain &= uncertain - 1) {
      const Vec2 q((*grid.parameter)[column_ + std::countr_zero(uncertain)].x(), row);
      if (segments_meet(p_, q, e.long_a, e.long_b)) hidden |= uncertain & -uncertain;
    }
    if (!callback(j, hidden)) return;
  }
}

void Visibility::update(const ControlGrid& grid, const CrackGraph& cracks, int end) {
  if (end <= known_) return;
  const Columns x = columns(grid);
  const auto hide = [&](const CrackEdge& e) {
    each_hidden(grid, x, e, [&](int j, unsigned hidden) {
      rows_[j] = static_cast<std::uint16_t>(rows_[j] & ~hidden);
      return true;
    });
  };
  if (end - known_ <= kFew) {
    for (int e = known_; e < end; ++e) hide(cracks.edges()[e]);
  } else {
    const Vec2 reach = kLargestSupport * Vec2(grid.spacing_u, grid.spacing_v);
    std::array<int, kRemembered> met;  // an edge comes once for each of its bins
    met.fill(-1);
    cracks.near_since(p_ - reach, p_ + reach, known_, [&](int e) {
      if (e < end && std::exchange(met[e % kRemembered], e) != e) hide(cracks.edges()[e]);
    });
  }
  known_ = end;
}

bool Visibility::loses(const ControlGrid& grid, const CrackEdge& edge) const {
  bool any = false;
  each_hidden(grid, columns(grid), edge, [&](int j, unsigned hidden) { return !(any = (hidden & rows_[j]) != 0); });
  return any;
}

}  // namespace sunder::shell
