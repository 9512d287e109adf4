#pragma once
// Visibility: the control points around a point that no crack hides. Cracks only grow, so what is hidden stays hidden,
// and only edges that are new since the last look are tested.
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "shell/fracture/constants.h"
#include "shell/fracture/crack_graph.h"

namespace sunder::shell {

/// Control points of a patch by their parameter points. These are a product: all of a column have the same first
/// coordinate, all of a row the same second one.
struct ControlGrid {
  int columns = 0, rows = 0;
  const std::vector<Vec2>* parameter = nullptr;
  double spacing_u = 0.0, spacing_v = 0.0;    // mean spacing [m]
  const std::vector<char>* absent = nullptr;  // 1 for control points that do not exist; null: all do

  /// Offset from p [spacings].
  Vec2 offset(const Vec2& p, int control_point) const {
    const Vec2& q = (*parameter)[control_point];
    return {(q.x() - p.x()) / spacing_u, (q.y() - p.y()) / spacing_v};
  }
};

/// The visible control points as a part of the product that the control grid is.
struct View {
  static constexpr int kMost = 15;        // columns, and rows
  int first = 0, stride = 0;              // the control point of column i, row j is first + j * stride + i
  int columns = 0, rows = 0;              // all visible ones are in the first so many of each
  double x[kMost], y[kMost];              // offsets from the point, in spacings; they rise
  std::array<std::uint16_t, kMost> seen;  // of each row, a bit for each column
};

class Visibility {
 public:
  Visibility() = default;
  /// All control points within the largest support of `p`, which lies in span_u, span_v: no edge hides any yet.
  Visibility(const ControlGrid& grid, const Vec2& p, int span_u, int span_v);
  /// Hides what the first `end` edges of the graph hide. No edge that it has taken in may be taken back.
  void update(const ControlGrid& grid, const CrackGraph& cracks, int end);
  const Vec2& point() const { return p_; }
  /// Whether the edge hides any visible control point.
  bool loses(const ControlGrid& grid, const CrackEdge& edge) const;
  /// Hides all control points, until these are shown, which must be within the largest support.
  void close() { rows_.fill(0); }
  void show(const ControlGrid& grid, int control_point) {
    const int j = control_point / grid.columns - row_, i = control_point % grid.columns - column_;
    rows_[j] = static_cast<std::uint16_t>(rows_[j] | 1u << i);
  }
  /// Whether two visibilities of one point are the same.
  bool sees_the_same(const Visibility& other) const { return rows_ == other.rows_; }
  /// Calls back each visible control point, in rising order.
  template <class F>
  void each(const ControlGrid& grid, F&& callback) const {
    for (int j = 0; j < kAcross; ++j)
      for (unsigned left = rows_[j]; left; left &= left - 1)
        callback((row_ + j) * grid.columns + column_ + std::countr_zero(left));
  }
  View view(const ControlGrid& grid) const;

 private:
  struct Columns;
  Columns columns(const ControlGrid& grid) const;
  /// Calls back rows with a bit for each control point that the edge hides, until false is returned. Some of them may
  /// be hidden already.
  template <class F>
  void each_hidden(const ControlGrid& grid, const Columns& x, const CrackEdge& edge, F&& callback) const;

  static constexpr int kReach = 7, kAcross = 2 * kReach + 1;  // one more than the support, rounded up
  static_assert(kAcross <= View::kMost);
  Vec2 p_ = Vec2::Zero();
  int column_ = 0, row_ = 0;                   // of the first control point that has a bit; may be negative
  int known_ = 0;                              // edges
  std::array<std::uint16_t, kAcross> rows_{};  // a bit for each control point
};

}  // namespace sunder::shell
