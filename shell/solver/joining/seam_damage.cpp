#include "shell/solver/joining/seam_damage.h"

#include <algorithm>

#include "shell/geometry/edges.h"

namespace sunder::shell {
namespace {

// Whether a Gauss point bears no tension any more: it is fully damaged now, or rubble. One that was
// handed off with a piece does not count.
bool is_spent(const ShellModel& m, const ShellState& s, int block, int lane) {
  if (s.cracked.point_of.empty()) return false;
  const int point = s.cracked.point_of[static_cast<std::size_t>(block) * m.tables.lanes + lane];
  if (point < 0) return false;
  const GatheredPoint& g = s.cracked.gathered[point];
  return g.kind == PointKind::kDead ? !g.handed_off : s.damage(point) >= 1.0f;
}

}  // namespace

SeamDamage::SeamDamage(const std::vector<Seam>& seams, const std::vector<const ShellModel*>& shells,
                       const std::vector<double>& reach) {
  for (std::size_t i = 0; i < seams.size(); ++i) {
    const Seam& seam = seams[i];
    if (seam.trimmed()) continue;
    for (const bool first : {true, false}) {
      const int k = first ? seam.first : seam.second, edge = first ? seam.first_edge : seam.second_edge;
      if (reach[k] <= 0.0) continue;
      const ShellModel& m = *shells[k];
      const bool along_v = edge < kVMin, high = edge == kUMax || edge == kVMax;
      const KnotVector& along = along_v ? m.patch.knots_v : m.patch.knots_u;
      const int gauss = m.tables.gauss, across = (along_v ? m.tables.spans_u : m.tables.spans_v) * gauss;
      const int depth = high ? across - 1 : 0;
      const double length = along.end() - along.begin();
      Side side{static_cast<int>(i), k, reach[k] / seam.length, m.longest_element / seam.length, {}};
      for (int span = 0; span < along.spans(); ++span)
        for (int q = 0; q < gauss; ++q) {
          const int n = span * gauss + q, column = along_v ? depth : n, row = along_v ? n : depth;
          double low = (along.span_begin(span) + along.span_length(span) * q / gauss - along.begin()) / length;
          double up = (along.span_begin(span) + along.span_length(span) * (q + 1) / gauss - along.begin()) / length;
          if (!first && seam.reversed) low = 1.0 - low, up = 1.0 - up, std::swap(low, up);
          side.cells.push_back({row * gauss + column % gauss, column / gauss, low, up});
        }
      if (!first && seam.reversed) std::reverse(side.cells.begin(), side.cells.end());
      sides_.push_back(std::move(side));
    }
  }
}

bool SeamDamage::open(const std::vector<ShellRef>& shells, const std::vector<Seam>& seams, Stitching& stitching) {
  bool any = false;
  for (Side& side : sides_) {
    const ShellRef& shell = shells[side.shell];
    for (std::size_t begin = 0; begin < side.cells.size();) {
      std::size_t end = begin;
      bool fresh = false;
      while (end < side.cells.size() &&
             is_spent(*shell.model, *shell.state, side.cells[end].block, side.cells[end].lane)) {
        fresh = fresh || !side.cells[end].open;
        ++end;
      }
      if (end == begin) {
        ++begin;
        continue;
      }
      const double from = side.cells[begin].low, to = side.cells[end - 1].high;
      const double low = begin == 0 ? from : from + side.margin;
      const double high = end == side.cells.size() ? to : to - side.margin;
      if (fresh && to - from > side.reach && high > low) {
        stitching.open(shells, seams[side.seam], low, high);
        for (std::size_t k = begin; k < end; ++k) side.cells[k].open = true;
        any = true;
      }
      begin = end;
    }
  }
  if (any) stitching.release_corners(shells, seams);
  return any;
}

}  // namespace sunder::shell
