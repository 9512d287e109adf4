#include "shell/solver/joining/held_together.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "coupler/core/disjoint_sets.h"

namespace sunder::shell {
namespace {

// Tests whether all layers of a point are fully damaged. Where one alone is, the others still pull.
bool bears_nothing(const ShellState& s, int point, std::size_t layers) {
  if (s.cracked.damage.empty()) return false;
  const auto& now = s.cracked.damage[point].now;
  return std::all_of(now.begin(), now.begin() + static_cast<std::ptrdiff_t>(layers), [](float c) { return c >= 1.0f; });
}

}  // namespace

std::vector<double> held_areas(const std::vector<ShellRef>& shells, const Stitching& stitching) {
  std::vector<int> first;
  DisjointSets together(0);
  for (const ShellRef& r : shells) {
    first.push_back(together.size());
    for (int i = 0; i < r.model->tables.component_stride; ++i) together.add();
  }
  struct Borne {
    int at;
    double area;
  };
  std::vector<Borne> borne;  // one slot of each Gauss point that bears, and its area
  for (std::size_t k = 0; k < shells.size(); ++k) {
    const RowTables& t = shells[k].model->tables;
    const ShellState& s = *shells[k].state;
    const auto hold = [&](int slot, int other) { together.join(first[k] + slot, first[k] + other); };
    for (int block = 0; block < t.blocks(); ++block)
      for (int lane = 0; lane < t.spans_u; ++lane) {
        const int point =
            s.cracked.point_of.empty() ? -1 : s.cracked.point_of[static_cast<std::size_t>(block) * t.lanes + lane];
        if (point >= 0) {
          const GatheredPoint& g = s.cracked.gathered[point];
          if (g.kind == PointKind::kDead || bears_nothing(s, point, t.layers.zeta.size())) continue;
          for (const GatheredFunction& f : g.functions) hold(g.functions.front().slot, f.slot);
          borne.push_back({first[k] + g.functions.front().slot, g.area});
          continue;
        }
        const double area = t.metric[t.at(block, kMetricFields, kArea, lane)];
        const int corner = block / t.gauss / t.gauss * t.stride + lane;
        if (area == 0.0 || s.motion.detached[corner] != 0) continue;
        for (int j = 0; j < t.support(); ++j)
          for (int i = 0; i < t.support(); ++i) hold(corner, corner + j * t.stride + i);
        borne.push_back({first[k] + corner, area});
      }
    for (int i = 1; i < shells[k].model->control_points() && shells[k].model->laminated(); ++i)
      hold(t.slot(0), t.slot(i));  // an interlayer holds cracked panes together
  }
  stitching.each_dependence([&](int shell, int slot, int other, int other_slot) {
    together.join(first[shell] + slot, first[other] + other_slot);
  });
  // A tie joins one control point of each shell, that of most weight: it reaches over no crack.
  stitching.each_tie([&](const std::vector<WeightedSlot>& terms) {
    std::map<int, WeightedSlot> most;
    for (const WeightedSlot& w : terms)
      if (WeightedSlot& own = most.try_emplace(w.shell, w).first->second; std::abs(w.weight) > std::abs(own.weight))
        own = w;
    for (const auto& [shell, own] : most)
      together.join(first[most.begin()->first] + most.begin()->second.slot, first[shell] + own.slot);
  });
  std::map<int, double> area;
  for (const Borne& b : borne) area[together.root(b.at)] += b.area;
  std::vector<double> areas;
  for (const auto& [root, sum] : area) areas.push_back(sum);
  std::sort(areas.begin(), areas.end(), std::greater<>());
  return areas;
}

}  // namespace sunder::shell
