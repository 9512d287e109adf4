#include "shell/solver/cracking/crack_sides.h"

#include <algorithm>

#include "coupler/core/disjoint_sets.h"
#include "shell/solver/cracking/insertion.h"

namespace sunder::shell {
namespace {

constexpr double kNear = 2.0;      // [spacings]
constexpr double kInwards = 0.01;  // of the way from a vertex to the middle of its fan

// Numbers the corners of all triangles. Corners at one vertex have the same number where their triangles are connected
// around it.
std::vector<std::array<int, 3>> fans(const Triangulation& t) {
  const int n = static_cast<int>(t.triangles.size());
  DisjointSets corners(3 * n);
  for (int i = 0; i < n; ++i)
    for (const int other : t.neighbours[i]) {
      if (other < 0) continue;
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l)
          if (t.triangles[i][k] == t.triangles[other][l]) corners.join(3 * i + k, 3 * other + l);
    }
  std::vector<std::array<int, 3>> fan(n);
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < 3; ++k) fan[i][k] = corners.root(3 * i + k);
  return fan;
}

}  // namespace

SidePoint side_point(const ShellModel& m, const ShellState& s, const Vec2& p, bool near_crack) {
  SidePoint c{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  const auto add = [&](double n, int slot) {
    c.x += n * s.position(slot), c.v += n * s.velocity(slot), c.u += n * (s.position(slot) - s.at(m.rest, slot));
  };
  const std::vector<GatheredFunction> functions = shell_functions(m, p);
  const auto visible = [&](int slot) {
    return s.cracks.graph.visible(
        p, m.trim.empty() ? m.parameter_of_slot[slot] : m.trim.home[m.tables.control_point(slot)]);
  };
  if (!near_crack || std::all_of(functions.begin(), functions.end(), [&](const auto& f) { return visible(f.slot); })) {
    for (const GatheredFunction& f : functions) add(f.n[0], f.slot);
    return c;
  }
  Visibility visibility =
      first_visibility(m, s.cracks.graph, p, m.patch.knots_u.span_of(p.x()), m.patch.knots_v.span_of(p.y()));
  visibility.update(control_grid(m), s.cracks.graph, static_cast<int>(s.cracks.graph.edges().size()));
  const MlsPoint mls = mls_point(control_grid(m), visibility);
  if (mls.basis != MlsBasis::kNone) {
    for (const MlsFunction& n : mls.functions) add(n.n[0], m.tables.slot(n.control_point));
    return c;
  }
  // Too few control points are visible: the point moves with the nearest one.
  int slot = 0;
  double distance = 1e300;
  for (const GatheredFunction& f : functions) {
    const double d = (m.parameter_of_slot[f.slot] - p).squaredNorm() + (visible(f.slot) ? 0.0 : 1.0);
    if (d < distance) distance = d, slot = f.slot;
  }
  c.u = s.position(slot) - s.at(m.rest, slot), c.v = s.velocity(slot);
  c.x = m.patch.evaluate(p).x + c.u;
  return c;
}

SideCorners side_corners(const ShellModel& m, const ShellState& s, const Triangulation& t) {
  std::vector<char> near(t.vertices.size(), 0);
  for (std::size_t i = 0; i < near.size(); ++i)
    if (!m.laminated())
      s.cracks.graph.near(t.vertices[i], t.vertices[i], kNear * m.spacing, [&](int e) {
        Vec2 foot;
        if (s.cracks.graph.distance(t.vertices[i], e, foot) < kNear * m.spacing) near[i] = 1;
        return !near[i];
      });
  const std::vector<std::array<int, 3>> fan = fans(t);
  SideCorners out;
  out.of.resize(fan.size());
  std::vector<int> number(3 * fan.size(), -1);  // by fan
  std::vector<Vec2> sum;                        // of centres, and their number: they tell the fan's side of the vertex
  std::vector<int> count;
  for (std::size_t i = 0; i < fan.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const auto& c = t.triangles[i];
      int& corner = number[fan[i][k]];
      if (corner < 0) {
        corner = static_cast<int>(out.corners.size());
        out.corners.push_back({t.vertices[c[k]], near[c[k]] != 0});
        sum.emplace_back(Vec2::Zero()), count.push_back(0);
      }
      out.of[i][k] = corner;
      sum[corner] += (t.vertices[c[0]] + t.vertices[c[1]] + t.vertices[c[2]]) / 3.0;
      ++count[corner];
    }
  for (std::size_t k = 0; k < out.corners.size(); ++k)
    if (Vec2& at = out.corners[k].at; out.corners[k].near) at += kInwards * (sum[k] / count[k] - at);
  return out;
}

}  // namespace sunder::shell
