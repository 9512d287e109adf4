#include "shell/solver/supports.h"

#include <algorithm>
#include <map>

#include "coupler/core/disjoint_sets.h"
#include "coupler/core/error.h"
#include "shell/geometry/parameter_place.h"

namespace sunder::shell {
namespace {

constexpr double kInPlane = 1e-9;                                            // share of the patch's size
constexpr const char* kEdgeNames[4] = {"u_min", "u_max", "v_min", "v_max"};  // in the order of kEdges
constexpr const char* kCornerNames[4] = {"u_min_v_min", "u_max_v_min", "u_min_v_max", "u_max_v_max"};

// A control point, and the number of the part that names it.
struct Named {
  int point, part;
};

}  // namespace

Vec3 Constraints::Driven::displacement(double time) const {
  if (time <= motion.front().first) return motion.front().second;
  for (std::size_t i = 1; i < motion.size(); ++i)
    if (time < motion[i].first) {
      const auto& [t0, a] = motion[i - 1];
      const auto& [t1, b] = motion[i];
      return a + (time - t0) / (t1 - t0) * (b - a);
    }
  return motion.back().second;
}

Constraints make_constraints(const Patch& p, const std::vector<Support>& supports, int stride, const std::string& name,
                             double time) {
  const int columns = p.columns(), rows = p.rows(), count = columns * rows;
  const auto slot = [&](int i) { return i / columns * stride + i % columns; };
  Vec3 low = p.control_points[0], high = low;
  for (const Vec3& x : p.control_points) low = low.cwiseMin(x), high = high.cwiseMax(x);
  const double size = (high - low).norm();
  const double tolerance = edge_tolerance(p);  // of regions: a border of a box that a scene rounds
  std::array<std::vector<char>, 3> held;
  std::array<std::vector<int>, 3> holder, mover;  // part that holds or drives a control point; -1: none
  // number of the motion that moves a control point, the last one named; -1: none
  std::array<std::vector<int>, 3> driver;
  std::array<DisjointSets, 3> tied{DisjointSets(count), DisjointSets(count), DisjointSets(count)};
  for (int d = 0; d < 3; ++d) {
    held[d].assign(count, 0);
    holder[d].assign(count, -1), mover[d].assign(count, -1);
    driver[d].assign(count, -1);
  }
  Constraints c;
  const auto hold = [&](int d, const Named& n) {
    held[d][n.point] = 1;
    if (holder[d][n.point] < 0) holder[d][n.point] = n.part;
  };
  for (std::size_t number = 0; number < supports.size(); ++number) {
    const Support& s = supports[number];
    const auto new_part = [&](const std::string& name) {
      c.parts.push_back({"support_" + std::to_string(number) + "_" + name, {}});
      return static_cast<int>(c.parts.size()) - 1;
    };
    const bool holds = time < s.until;
    std::vector<Named> points, slopes;
    for (std::size_t e = 0; e < std::size(kEdges); ++e) {
      const int edge = kEdges[e];
      if (!(s.edges & edge)) continue;
      const int part = new_part(kEdgeNames[e]);
      const std::vector<int> first = edge_row(p, edge, 0), second = edge_row(p, edge, 1);
      if (s.symmetry >= 0) {
        for (const int i : first)
          require(std::abs(p.control_points[i][s.symmetry] - p.control_points[first[0]][s.symmetry]) <= kInPlane * size,
                  "{}: a symmetry edge must lie in a plane across {}; it runs from {:.6g} to {:.6g} m", name,
                  "xyz"[s.symmetry], p.control_points[first[0]][s.symmetry], p.control_points[i][s.symmetry]);
        for (std::size_t k = 0; k < first.size() && holds; ++k) {
          hold(s.symmetry, {first[k], part});
          c.anchors.push_back(slot(first[k]));
          for (int d = 0; d < 3; ++d)
            if (d != s.symmetry) tied[d].join(first[k], second[k]);
        }
        continue;
      }
      for (const int i : first) points.push_back({i, part});
      for (const int i : second)
        if (s.clamped) slopes.push_back({i, part});
    }
    const int corner[4] = {0, columns - 1, (rows - 1) * columns, count - 1};
    for (int k = 0; k < 4; ++k)
      if (s.corners & (1 << k)) points.push_back({corner[k], new_part(std::string("corner_") + kCornerNames[k])});
    for (std::size_t r = 0; r < s.regions.size(); ++r) {
      const ParameterBox& box = s.regions[r];
      const int part = new_part("region_" + std::to_string(r));
      const std::size_t before = points.size();
      for (int i = 0; i < count; ++i) {
        const Vec2 g = p.greville(i);
        if ((g.array() >= box.low.array() - tolerance).all() && (g.array() <= box.high.array() + tolerance).all())
          points.push_back({i, part});
      }
      require(points.size() > before,
              "{}: no control point lies in u {:.9g} to {:.9g}, v {:.9g} to {:.9g}; parameters run {}", name,
              box.low.x(), box.high.x(), box.low.y(), box.high.y(), parameter_range(p));
    }
    for (std::size_t b = 0; b < s.in_boxes.size(); ++b) {
      if (s.in_boxes[b].empty()) continue;
      const int part = new_part("box_" + std::to_string(b));
      for (const int i : s.in_boxes[b]) points.push_back({i, part});
    }
    if (!holds) continue;
    for (const Named& n : points) c.anchors.push_back(slot(n.point));
    points.insert(points.end(), slopes.begin(), slopes.end());
    if (s.motion.empty()) {
      for (const Named& n : points)
        for (int d = 0; d < 3; ++d)
          if (s.axes[d]) hold(d, n);
      continue;
    }
    for (const Named& n : points)
      for (int d = 0; d < 3; ++d)
        if (s.axes[d] && driver[d][n.point] != static_cast<int>(c.driven.size()))
          driver[d][n.point] = static_cast<int>(c.driven.size()), mover[d][n.point] = n.part;
    c.driven.push_back({{}, s.motion});
  }
  for (int d = 0; d < 3; ++d) {
    std::map<int, std::vector<int>> groups;
    for (int i = 0; i < count; ++i) groups[tied[d].root(i)].push_back(i);
    for (const auto& [first, members] : groups) {  // one held member holds the group; one driven member drives it
      bool any = false;
      int by = -1, part_held = -1, part_moved = -1;
      std::vector<int> slots;
      for (const int i : members) {
        any = any || held[d][i];
        if (part_held < 0) part_held = holder[d][i];
        if (part_moved < 0) part_moved = mover[d][i];
        if (driver[d][i] >= 0) {
          require(by < 0 || by == driver[d][i], "{}: control points of a symmetry edge move in two ways at once", name);
          by = driver[d][i];
        }
        slots.push_back(slot(i));
      }
      std::vector<int>* list = any ? &c.held[d] : by >= 0 ? &c.driven[by].slots[d] : nullptr;
      if (list) {
        list->insert(list->end(), slots.begin(), slots.end());
        std::vector<int>& own = c.parts[any ? part_held : part_moved].slots[d];
        own.insert(own.end(), slots.begin(), slots.end());
      } else if (slots.size() > 1)
        c.tied[d].push_back(slots);
      c.partial = c.partial || (!any && (by >= 0 || slots.size() > 1));
    }
    std::sort(c.held[d].begin(), c.held[d].end());
  }
  c.partial = c.partial || c.held[0] != c.held[1] || c.held[1] != c.held[2];
  return c;
}

}  // namespace sunder::shell
