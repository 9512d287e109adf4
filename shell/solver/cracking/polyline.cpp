#include "shell/solver/cracking/polyline.h"

#include <algorithm>
#include <cmath>

#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/tips.h"

namespace sunder::shell {
namespace {

// The vertex of an earlier crack at p, or -1. `vertices`: number of earlier ones.
int vertex_on(const ShellModel& m, const CrackGraph& cracks, const Vec2& p, int vertices) {
  double nearest = kCutOnCrack * m.spacing;
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

// Vertices of earlier cracks that a segment from a to b passes over between its ends, in its order.
std::vector<int> vertices_between(const ShellModel& m, const CrackGraph& cracks, const Vec2& a, const Vec2& b,
                                  int vertices) {
  const double near = kCutOnCrack * m.spacing, length = (b - a).norm();
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

// Whether all of the element at p has detached: there is nothing to cut.
bool has_left(const ShellModel& m, const ShellState& s, const Vec2& p) {
  if (!m.patch.contains(p)) return false;
  const int lane = m.patch.knots_u.span_of(p.x()), each = m.tables.gauss * m.tables.gauss;
  const int first = each * m.patch.knots_v.span_of(p.y());
  for (int block = first; block < first + each; ++block) {
    const int point = s.cracked.point_of[static_cast<std::size_t>(block) * m.tables.lanes + lane];
    if (point >= 0 ? !s.cracked.gathered[point].handed_off
                   : s.cracked.tables.metric[m.tables.at(block, kMetricFields, kArea, lane)] != 0.0)
      return false;
  }
  return true;
}

}  // namespace

void insert_polyline(const ShellModel& m, ShellState& s, const std::vector<Vec2>& points, double time, bool interlock) {
  const int crack = s.cracks.graph.new_crack(), earlier = static_cast<int>(s.cracks.graph.vertices().size());
  const auto run_out = [&](Vec2 end, const Vec2& from) {
    const Vec2 d = (end - from).normalized();
    // an end on another crack ends a little past it, so that no gap is left
    double nearest = kCutOnCrack * m.spacing;
    Vec2 landed = end;
    s.cracks.graph.near(end, end, nearest, [&](int e) {
      Vec2 foot;
      const double distance = s.cracks.graph.distance(end, e, foot);  // it has no edges yet
      if (distance < nearest) nearest = distance, landed = foot + kJoinPast * m.spacing * d;
      return true;
    });
    // at the border it runs over it, further than visibility needs
    if (landed == end && !m.patch.contains(end + kCutAtBorder * m.spacing * d))
      landed = end + kCutRunOut * m.spacing * d;
    return landed;
  };
  // A cut that comes upon a vertex of another crack goes through that vertex: two ends in one point, or the other crack
  // ends on this one. Lines that only touch may leave a gap of round-off.
  const auto vertex_at = [&](const Vec2& p) {
    const int known = vertex_on(m, s.cracks.graph, p, earlier);
    return known >= 0 ? known : s.cracks.graph.add_vertex(p);
  };
  const Vec2 off = m.patch.degree() == 3 ? Vec2(kOffKnots * m.spacing * Vec2(kNudgeU, kNudgeV)) : Vec2(Vec2::Zero());
  const bool closed = points.size() > 2 && points.front() == points.back();
  int first = -1, last = -1;
  std::vector<std::pair<int, int>> edges;  // all are found before the first changes which points are detached
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
    if (from != to && !has_edge(s.cracks.graph, from, to)) insert_edge(m, s, from, to, crack, time, 0, interlock);
}

namespace {

int make_cuts(const CrackLook& k) {
  ShellState& s = k.state;
  const auto edges = [&] { return static_cast<int>(s.cracks.graph.edges().size()); };
  const int all = edges();
  std::vector<std::pair<int, int>> made;  // first edge, and the one after the last
  for (std::size_t i = 0; i < k.rules.cuts.size(); ++i) {
    const PrescribedCut& cut = k.rules.cuts[i];
    if (s.cracks.cut_done[i] || cut.time > k.time + k.span) continue;
    const int before = edges();
    for (const auto& line : cut.lines) insert_polyline(k.model, s, line, k.time, k.rules.cut_faces);
    if (k.on_edges) k.on_edges->insert(k.on_edges->end(), cut.on_edges.begin(), cut.on_edges.end());
    if (!cut.goes_on) made.emplace_back(before, edges());
    s.cracks.cut_done[i] = 1;
  }
  if (k.rules.tips_run())  // after all cuts: an end on another cut is not open
    for (const auto& [first, last] : made) start_at_ends(k.model, s, first, last);
  return edges() - all;
}

}  // namespace

Criterion prescribed_cuts() {
  return {"prescribed_cuts", CrackMoment::kWindow, [](const FractureRules& r) { return !r.cuts.empty(); }, make_cuts};
}

}  // namespace sunder::shell
