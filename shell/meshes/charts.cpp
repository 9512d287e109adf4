#include "shell/meshes/charts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <queue>

#include "coupler/core/error.h"
#include "shell/geometry/plane_curves.h"

namespace sunder::shell {
namespace {

using Creases = std::vector<std::array<char, 3>>;

constexpr double kShareAbove = 0.01;    // of a chart's area that may be stretched more than asked for
constexpr double kOverstretched = 4.0;  // the most of any triangle, overlap included
constexpr int kRecentred = 6;           // rounds that move the seeds of both halves to their middles
constexpr int kSmoothed = 12;           // rounds that take spikes off a border
constexpr double kAvoid = 20.0;         // how much longer a way is where it is near the one that it shall avoid
constexpr double kTouches = 1e-9;       // of the size: borders of a chart in the plane are further apart

// Shortest ways over triangles, from middle to middle, within a part.
class Ways {
 public:
  Ways(const TriangleMesh& m, const Creases& creases, const std::vector<int>& part)
      : m_(m), creases_(creases), inside_(m.triangles.size(), 0) {
    for (const int t : part) inside_[t] = 1;
  }

  struct Found {
    std::vector<double> length;
    std::vector<int> from, source;  // the triangle before; the number of the seed set
  };
  /// `factor(t)` multiplies lengths in triangle t; ways are no longer than `most`.
  template <class F>
  Found from(const std::vector<std::vector<int>>& seeds, F&& factor,
             double most = std::numeric_limits<double>::infinity()) const {
    Found out{std::vector<double>(m_.triangles.size(), std::numeric_limits<double>::infinity()),
              std::vector<int>(m_.triangles.size(), -1), std::vector<int>(m_.triangles.size(), -1)};
    std::priority_queue<std::pair<double, int>, std::vector<std::pair<double, int>>, std::greater<>> next;
    for (std::size_t s = 0; s < seeds.size(); ++s)
      for (const int t : seeds[s]) out.length[t] = 0.0, out.source[t] = static_cast<int>(s), next.emplace(0.0, t);
    while (!next.empty()) {
      const auto [length, t] = next.top();
      next.pop();
      if (length > out.length[t]) continue;
      for (int k = 0; k < 3; ++k) {
        const int other = m_.beside[t][k];
        if (other < 0 || !inside_[other] || creases_[t][k]) continue;
        const Vec3 gate = 0.5 * (m_.points[m_.triangles[t][k]] + m_.points[m_.triangles[t][(k + 1) % 3]]);
        const double to =
            length + factor(t) * (gate - m_.middle(t)).norm() + factor(other) * (m_.middle(other) - gate).norm();
        if (to >= out.length[other] || to > most) continue;
        out.length[other] = to, out.from[other] = t, out.source[other] = out.source[t];
        next.emplace(to, other);
      }
    }
    return out;
  }
  Found from(const std::vector<std::vector<int>>& seeds) const {
    return from(seeds, [](int) { return 1.0; });
  }

 private:
  const TriangleMesh& m_;
  const Creases& creases_;
  std::vector<char> inside_;
};

std::vector<int> all_of(const TriangleMesh& m) {
  std::vector<int> out(m.triangles.size());
  for (std::size_t t = 0; t < out.size(); ++t) out[t] = static_cast<int>(t);
  return out;
}

// Parts of `triangles` that hang together over edges that are no creases, where `label` is the same.
std::vector<std::vector<int>> connected_parts(const TriangleMesh& m, const Creases& creases,
                                              const std::vector<int>& triangles, const std::vector<int>& label) {
  std::vector<char> left(m.triangles.size(), 0);
  for (const int t : triangles) left[t] = 1;
  std::vector<std::vector<int>> out;
  for (const int seed : triangles) {
    if (!left[seed]) continue;
    std::vector<int> part{seed};
    left[seed] = 0;
    for (std::size_t k = 0; k < part.size(); ++k)
      for (int e = 0; e < 3; ++e) {
        const int other = m.beside[part[k]][e];
        if (other >= 0 && left[other] && !creases[part[k]][e] && label[other] == label[seed])
          left[other] = 0, part.push_back(other);
      }
    std::sort(part.begin(), part.end());
    out.push_back(std::move(part));
  }
  return out;
}

// Loops of the border of a part, as triangles beside them, the longest first.
std::vector<std::vector<int>> border_loops(const TriangleMesh& m, const std::vector<int>& part) {
  std::vector<char> own(m.triangles.size(), 0);
  for (const int t : part) own[t] = 1;
  std::map<int, std::pair<int, int>> next;  // point: the next one, and the triangle beside
  for (const int t : part)
    for (int k = 0; k < 3; ++k) {
      const int other = m.beside[t][k];
      if (other < 0 || !own[other]) next[m.triangles[t][k]] = {m.triangles[t][(k + 1) % 3], t};
    }
  std::vector<std::pair<double, std::vector<int>>> loops;
  while (!next.empty()) {
    auto& [length, beside] = loops.emplace_back();
    for (int at = next.begin()->first; next.count(at) != 0;) {
      const auto [to, t] = next[at];
      length += (m.points[to] - m.points[at]).norm(), beside.push_back(t);
      next.erase(at), at = to;
    }
  }
  std::stable_sort(loops.begin(), loops.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::vector<int>> out;
  for (auto& loop : loops) out.push_back(std::move(loop.second));
  return out;
}

// Takes triangles that stick into the other side over to it: the border has fewer edges then.
void take_spikes(const TriangleMesh& m, const Creases& creases, const std::vector<int>& part, std::vector<int>& label) {
  for (int round = 0; round < kSmoothed; ++round) {
    bool any = false;
    for (const int t : part) {
      int other = 0, same = 0, to = 0;
      for (int k = 0; k < 3; ++k) {
        const int n = m.beside[t][k];
        if (n < 0 || creases[t][k] || label[n] < 0) continue;
        if (label[n] == label[t])
          ++same;
        else
          ++other, to = label[n];
      }
      if (other >= 2 && same <= 1) label[t] = to, any = true;
    }
    if (!any) return;
  }
}

class Divider {
 public:
  Divider(const TriangleMesh& m, const Creases& creases, const ChartRules& rules)
      : m_(m), creases_(creases), rules_(rules) {}

  std::vector<Chart> all() const {
    std::vector<std::vector<int>> left = connected_parts(
        m_, creases_, all_of(m_), rules_.parts.empty() ? std::vector<int>(m_.triangles.size(), 0) : rules_.parts);
    std::reverse(left.begin(), left.end());
    std::vector<Chart> out;
    while (!left.empty()) {
      std::vector<int> part = std::move(left.back());
      left.pop_back();
      if (std::optional<Chart> chart = flat(part)) {
        out.push_back(std::move(*chart));
        continue;
      }
      require(part.size() > 1, "the triangle at ({:.6g}, {:.6g}, {:.6g}) cannot be flattened", m_.middle(part[0]).x(),
              m_.middle(part[0]).y(), m_.middle(part[0]).z());
      std::vector<std::vector<int>> halves = divided(part);
      for (auto half = halves.rbegin(); half != halves.rend(); ++half) left.push_back(std::move(*half));
    }
    return out;
  }

 private:
  std::optional<Chart> flat(const std::vector<int>& part) const {
    const PartShape shape = shape_of(m_, part);
    if (shape.handles != 0 || shape.loops == 0) return std::nullopt;
    for (const double reach : {rules_.overlap, 0.5 * rules_.overlap, 0.0}) {
      const std::vector<int> all = with_neighbours(m_, creases_, part, reach);
      if (reach > 0.0) {
        const PartShape whole = shape_of(m_, all);
        if (whole.handles != 0 || whole.loops == 0) continue;
      }
      std::optional<Flat> f = flatten(m_, all);
      if (f && is_good(*f, part.size())) return Chart{part, std::move(*f)};
    }
    return std::nullopt;
  }

  bool is_good(const Flat& f, std::size_t own) const {
    double area = 0.0, above = 0.0;
    for (std::size_t k = 0; k < f.triangles.size(); ++k) {
      if (f.most[k] > kOverstretched) return false;
      if (k >= own) continue;
      area += m_.area(f.triangles[k]);
      if (f.most[k] > rules_.most_stretch) above += m_.area(f.triangles[k]);
    }
    return above <= kShareAbove * area && is_simple(f, own);
  }

  // Whether no loop of the border meets itself in the plane: without triangles turned over the map is then one to one.
  bool is_simple(const Flat& f, std::size_t own) const {
    std::vector<char> mine(m_.triangles.size(), 0);
    for (std::size_t k = 0; k < own; ++k) mine[f.triangles[k]] = 1;
    std::map<int, int> next;
    double size = 0.0;
    for (std::size_t k = 0; k < own; ++k)
      for (int e = 0; e < 3; ++e) {
        const int t = f.triangles[k], other = m_.beside[t][e];
        if (other < 0 || !mine[other]) next[m_.triangles[t][e]] = m_.triangles[t][(e + 1) % 3];
      }
    while (!next.empty()) {
      std::vector<Vec2> loop;
      const int start = next.begin()->first;
      for (int at = start; next.count(at) != 0;) {
        const int to = next[at];
        loop.push_back(f.at[f.local[at]]), size = std::max(size, (loop.back() - loop.front()).norm());
        next.erase(at), at = to;
      }
      loop.push_back(loop.front());
      if (meets_itself(loop, kTouches * size)) return false;
    }
    return true;
  }

  std::vector<std::vector<int>> divided(const std::vector<int>& part) const {
    const std::vector<std::vector<int>> loops = border_loops(m_, part);
    if (loops.size() >= 2 && shape_of(m_, part).handles == 0) {
      std::vector<std::vector<int>> strips = cut(part, ways_between(part, loops[0], loops[1]));
      if (strips.size() >= 2) return strips;
    }
    const Ways ways(m_, creases_, part);
    const auto farthest = [&](int from) {
      const Ways::Found found = ways.from({{from}});
      int best = from;
      for (const int t : part)
        if (found.length[t] < std::numeric_limits<double>::infinity() && found.length[t] > found.length[best]) best = t;
      return best;
    };
    std::vector<std::vector<int>> seeds(2);
    seeds[0] = {farthest(part[0])}, seeds[1] = {farthest(seeds[0][0])};
    for (int round = 0; round < kRecentred; ++round) {
      const Ways::Found found = ways.from(seeds);
      std::array<Vec3, 2> middle{Vec3::Zero(), Vec3::Zero()};
      std::array<double, 2> area{};
      for (const int t : part)
        if (found.source[t] >= 0) {
          const double own = m_.area(t);
          middle[found.source[t]] += own * m_.middle(t), area[found.source[t]] += own;
        }
      std::array<int, 2> nearest{-1, -1};
      std::array<double, 2> least{1e300, 1e300};
      for (const int t : part)
        if (const int s = found.source[t]; s >= 0)
          if (const double away = (m_.middle(t) - middle[s] / area[s]).norm(); away < least[s])
            least[s] = away, nearest[s] = t;
      if (nearest[0] == seeds[0][0] && nearest[1] == seeds[1][0]) break;
      seeds = {{nearest[0]}, {nearest[1]}};
    }
    std::vector<std::vector<int>> out = cut(part, seeds);
    if (out.size() >= 2) return out;
    // What is left is small: one triangle by itself, and the others.
    std::vector<int> label(m_.triangles.size(), -1);
    for (const int t : part) label[t] = t == part[0] ? 0 : 1;
    return connected_parts(m_, creases_, part, label);
  }

  // Two ways from one loop to the other, far from each other: a tube is divided between them.
  std::vector<std::vector<int>> ways_between(const std::vector<int>& part, const std::vector<int>& first,
                                             const std::vector<int>& second) const {
    const Ways ways(m_, creases_, part);
    const auto way = [&](const Ways::Found& found) {
      int end = second[0];
      for (const int t : second)
        if (found.length[t] < found.length[end]) end = t;
      std::vector<int> out;
      for (int t = end; t >= 0; t = found.from[t]) out.push_back(t);
      return out;
    };
    const std::vector<int> one = way(ways.from({first}));
    const Ways::Found away = ways.from({one});
    double most = 0.0;
    for (const int t : part)
      if (std::isfinite(away.length[t])) most = std::max(most, away.length[t]);
    const std::vector<int> other = way(ways.from({first}, [&](int t) {
      const double near = 1.0 - away.length[t] / most;
      return 1.0 + kAvoid * near * near;
    }));
    return {one, other};
  }

  // Parts nearer to one of both seeds than to the other.
  std::vector<std::vector<int>> cut(const std::vector<int>& part, const std::vector<std::vector<int>>& seeds) const {
    std::vector<int> label(m_.triangles.size(), -1);
    const Ways::Found found = Ways(m_, creases_, part).from(seeds);
    for (const int t : part) label[t] = std::max(0, found.source[t]);
    take_spikes(m_, creases_, part, label);
    return connected_parts(m_, creases_, part, label);
  }

  const TriangleMesh& m_;
  const Creases& creases_;
  ChartRules rules_;
};

}  // namespace

std::vector<std::array<char, 3>> without_small_parts(const TriangleMesh& m, Creases creases, double area,
                                                     const std::vector<int>& labels) {
  const std::vector<int> label = labels.empty() ? std::vector<int>(m.triangles.size(), 0) : labels;
  for (bool again = true; again;) {
    again = false;
    const std::vector<std::vector<int>> parts = connected_parts(m, creases, all_of(m), label);
    std::vector<int> part_of(m.triangles.size(), -1);
    std::vector<double> size(parts.size(), 0.0);
    for (std::size_t p = 0; p < parts.size(); ++p)
      for (const int t : parts[p]) part_of[t] = static_cast<int>(p), size[p] += m.area(t);
    std::vector<char> joined(parts.size(), 0);
    for (std::size_t p = 0; p < parts.size(); ++p) {
      if (size[p] >= area || joined[p]) continue;
      std::map<int, double> beside;  // length of border with other parts
      const auto each_border = [&](auto&& f) {
        for (const int t : parts[p])
          for (int k = 0; k < 3; ++k)
            if (const int other = m.beside[t][k];
                other >= 0 && part_of[other] != static_cast<int>(p) && label[other] == label[t])
              f(t, k, other);
      };
      each_border([&](int t, int k, int other) {
        beside[part_of[other]] += (m.points[m.triangles[t][(k + 1) % 3]] - m.points[m.triangles[t][k]]).norm();
      });
      if (beside.empty()) continue;
      const int to = std::max_element(beside.begin(), beside.end(), [](const auto& a, const auto& b) {
                       return a.second < b.second;
                     })->first;
      each_border([&](int t, int k, int other) {
        if (part_of[other] != to) return;
        creases[t][k] = 0;
        for (int e = 0; e < 3; ++e)
          if (m.beside[other][e] == t) creases[other][e] = 0;
      });
      joined[p] = joined[to] = 1, again = true;
    }
  }
  return creases;
}

std::vector<int> with_neighbours(const TriangleMesh& m, const Creases& creases, const std::vector<int>& triangles,
                                 double reach) {
  std::vector<int> out = triangles;
  if (reach <= 0.0) return out;
  const Ways::Found found = Ways(m, creases, all_of(m))
                                .from(
                                    {triangles}, [](int) { return 1.0; }, reach);
  for (std::size_t t = 0; t < m.triangles.size(); ++t)
    if (found.length[t] > 0.0 && std::isfinite(found.length[t])) out.push_back(static_cast<int>(t));
  return out;
}

std::vector<Chart> charts_of(const TriangleMesh& m, const Creases& creases, const ChartRules& rules) {
  return Divider(m, creases, rules).all();
}

}  // namespace sunder::shell
