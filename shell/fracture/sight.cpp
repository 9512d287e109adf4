#include "shell/fracture/sight.h"

#include <algorithm>
#include <cmath>

namespace sunder::shell {

Sight::Sight(const ControlGrid& grid, const Vec2& p, int span_u, int span_v)
    : p_(p), column_(span_u + 1 - kReach), row_(span_v + 1 - kReach) {
  static_assert(kReach > kLargestSupport + 1.0);
  for (int j = std::max(0, -row_); j < std::min(kAcross, grid.rows - row_); ++j)
    for (int i = std::max(0, -column_); i < std::min(kAcross, grid.columns - column_); ++i)
      if (grid.offset(p, (row_ + j) * grid.columns + column_ + i).cwiseAbs().maxCoeff() < kLargestSupport)
        rows_[j] = static_cast<std::uint16_t>(rows_[j] | 1u << i);
}

void Sight::update(const ControlGrid& grid, const CrackGraph& cracks, int end) {
  const Vec2 reach = kLargestSupport * Vec2(grid.spacing_u, grid.spacing_v);
  cracks.near_since(p_ - reach, p_ + reach, known_, [&](int e) {
    if (e < end) hide(grid, cracks.edges()[e]);
  });
  known_ = std::max(known_, end);
}

void Sight::hide(const ControlGrid& grid, const CrackEdge& e) {
  const Vec2 low = e.long_a.cwiseMin(e.long_b), high = e.long_a.cwiseMax(e.long_b);
  for (int j = 0; j < kAcross; ++j) {
    unsigned left = rows_[j];
    if (left == 0) continue;
    const int first = (row_ + j) * grid.columns + column_;
    const double y = (*grid.parameter)[first + std::countr_zero(left)].y();
    if (std::max(p_.y(), y) < low.y() || std::min(p_.y(), y) > high.y()) continue;
    for (; left; left &= left - 1) {
      const int i = std::countr_zero(left);
      const Vec2& q = (*grid.parameter)[first + i];
      if (std::max(p_.x(), q.x()) < low.x() || std::min(p_.x(), q.x()) > high.x()) continue;
      if (segments_meet(p_, q, e.long_a, e.long_b)) rows_[j] = static_cast<std::uint16_t>(rows_[j] & ~(1u << i));
    }
  }
}

}  // namespace sunder::shell
