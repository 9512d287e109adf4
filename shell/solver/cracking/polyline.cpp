#include "shell/solver/cracking/polyline.h"

#include <algorithm>
#include <cmath>

#include "shell/solver/cracking/insertion.h"

namespace sunder::shell {
namespace {

constexpr double kAtBorder = 0.1;                 // spacings: a cut that ends so close to the border runs out
constexpr double kOnACrack = 0.02, kPast = 2e-3;  // spacings: a cut that comes so close to a crack meets it
// Control points of a uniform cubic patch lie on knots, where a cut at round numbers runs, and round-off would put one
// on either side of it, edge by edge. Spacings off, each is clearly on one.
constexpr double kOffKnots = 1e-6;

// The vertex of an earlier crack on which a point is, or -1. `vertices`: how many are earlier.
int vertex_on(const ShellModel& m, const CrackGraph& cracks, const Vec2& p, int vertices) {
  double nearest = kOnACrack * m.spacing;
  int found = -1;
  cracks.near(p, p, nearest, [&](int e) {
    for (const int v : {cracks.edges()[e].from, cracks.edges()[e].to}) {
      const double distance = (cracks.vertices()[v] - p).norm();
      if (v < vertices && distance < nearest) nearest = distance, found = v;
    }
    return true;
  });
  return found;
}

// Those which a segment from a to b passes over between its ends, in its order.
std::vector<int> vertices_between(const ShellModel& m, const CrackGraph& cracks, const Vec2& a, const Vec2& b,
                                  int vertices) {
  const double near = kOnACrack * m.spacing, length = (b - a).norm();
  const Vec2 along = (b - a) / length;
  std::vector<std::pair<double, int>> found;
  cracks.near(a, b, near, [&](int e) {
    for (const int v : {cracks.edges()[e].from, cracks.edges()[e].to}) {
      const Vec2 d = cracks.vertices()[v] - a;
      const double at = d.dot(along);
      if (v < vertices && at > near && at < length - near && (d - at * along).norm() < near) found.emplace_back(at, v);
    }
    return true;
  });
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  std::vector<int> order;
  for (const auto& [at, v] : found) order.push_back(v);
  return order;
}

bool has_edge(const CrackGraph& cracks, int from, int to) {
  bool found = false;
  cracks.near(cracks.vertices()[from], cracks.vertices()[to], 0.0, [&](int e) {
    const CrackEdge& c = cracks.edges()[e];
    found = (c.from == from && c.to == to) || (c.from == to && c.to == from);
    return !found;
  });
  return found;
}

// Whether all of the element at p has come off: there is nothing to cut.
bool has_left(const ShellModel& m, const ShellState& s, const Vec2& p) {
  if (!m.patch.contains(p)) return false;
  const int lane = m.patch.knots_u.span_of(p.x()), each = m.tables.gauss * m.tables.gauss;
  const int first = each * m.patch.knots_v.span_of(p.y());
  for (int block = first; block < first + each; ++block) {
    const int point = s.cracked.point_of[static_cast<std::size_t>(block) * m.tables.lanes + lane];
    if (point >= 0 ? !s.cracked.gathered[point].left
                   : s.cracked.tables.metric[m.tables.at(block, kMetricFields, kArea, lane)] != 0.0)
      return false;
  }
  return true;
}

}  // namespace

void insert_polyline(const ShellModel& m, ShellState& s, const std::vector<Vec2>& points, double time) {
  const int crack = s.cracks.graph.new_crack(), earlier = static_cast<int>(s.cracks.graph.vertices().size());
  const auto run_out = [&](Vec2 end, const Vec2& from) {
    const Vec2 d = (end - from).normalized();
    // an end on another crack goes a little past it, so that no gap is left
    double nearest = kOnACrack * m.spacing;
    Vec2 landed = end;
    s.cracks.graph.near(end, end, nearest, [&](int e) {
      Vec2 foot;
      const double distance = s.cracks.graph.distance(end, e, foot);  // none is its own yet
      if (distance < nearest) nearest = distance, landed = foot + kPast * m.spacing * d;
      return true;
    });
    // at the border it goes on over it, by more than visibility needs
    if (landed == end && !m.patch.contains(end + kAtBorder * m.spacing * d)) landed = end + 1.01 * m.spacing * d;
    return landed;
  };
  // Where it comes upon a vertex of another crack, as where two end in one point or the other ends on this one, it goes
  // through that: lines that only touch may leave a gap of round-off.
  const auto vertex_at = [&](const Vec2& p) {
    const int known = vertex_on(m, s.cracks.graph, p, earlier);
    return known >= 0 ? known : s.cracks.graph.add_vertex(p);
  };
  const Vec2 off = m.patch.degree() == 3 ? Vec2(kOffKnots * m.spacing * Vec2(1.0, 1.3)) : Vec2(Vec2::Zero());
  const bool closed = points.size() > 2 && points.front() == points.back();
  int first = -1, last = -1;
  std::vector<std::pair<int, int>> edges;  // all are found before one changes which points have come off
  const auto go_to = [&](int next) {
    const Vec2 a = s.cracks.graph.vertices()[last], b = s.cracks.graph.vertices()[next];
    const int pieces = std::max(1, static_cast<int>(std::ceil((b - a).norm() / m.spacing)));
    for (int k = 1; k <= pieces; ++k) {
      const int to = k == pieces ? next : s.cracks.graph.add_vertex(a + (b - a) * (static_cast<double>(k) / pieces));
      const Vec2 &p = s.cracks.graph.vertices()[last], &q = s.cracks.graph.vertices()[to];
      if (!(has_left(m, s, p) && has_left(m, s, 0.5 * (p + q)) && has_left(m, s, q))) edges.emplace_back(last, to);
      last = to;
    }
  };
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    Vec2 a = points[i] + off, b = points[i + 1] + off;
    const bool at_end = i + 2 == points.size();
    if (i == 0 && !closed && vertex_on(m, s.cracks.graph, a, earlier) < 0) a = run_out(a, b);
    if (at_end && !closed && vertex_on(m, s.cracks.graph, b, earlier) < 0) b = run_out(b, points[i] + off);
    if (last < 0) first = last = vertex_at(a);
    const std::vector<int> over = vertices_between(m, s.cracks.graph, s.cracks.graph.vertices()[last], b, earlier);
    for (const int v : over) go_to(v);
    go_to(at_end && closed ? first : vertex_at(b));
  }
  for (const auto& [from, to] : edges)
    if (from != to && !has_edge(s.cracks.graph, from, to)) insert_edge(m, s, from, to, crack, time, 0, false);
}

}  // namespace sunder::shell
