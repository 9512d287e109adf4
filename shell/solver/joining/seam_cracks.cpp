#include "shell/solver/joining/seam_cracks.h"

#include <algorithm>
#include <cmath>

#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/cracking/tips.h"
#include "shell/solver/joining/trim_cracks.h"

namespace sunder::shell {
namespace {

// The place where a crack edge leaves the domain.
struct EdgeExit {
  int edge = 0;
  double share = 0.0;  // share of the edge's parameters
  Vec2 at, direction;
};

bool exit_of(const ShellModel& m, const Vec2& from, const Vec2& to, EdgeExit& out) {
  const Vec2 low(m.patch.knots_u.begin(), m.patch.knots_v.begin()), high(m.patch.knots_u.end(), m.patch.knots_v.end());
  const Vec2 d = to - from;
  if (!m.patch.contains(from) || m.patch.contains(to)) return false;
  double nearest = 2.0;
  for (int axis = 0; axis < 2; ++axis)
    for (const bool far : {false, true}) {
      const double border = far ? high[axis] : low[axis];
      if (far ? to[axis] <= border : to[axis] >= border) continue;
      const double t = (border - from[axis]) / d[axis];
      if (t >= nearest) continue;
      nearest = t;
      out.edge = axis == 0 ? (far ? kUMax : kUMin) : (far ? kVMax : kVMin);
      out.at = from + t * d;
      out.at[axis] = border;
      out.share = (out.at[1 - axis] - low[1 - axis]) / (high[1 - axis] - low[1 - axis]);
    }
  out.direction = d.normalized();
  return nearest <= 1.0 && out.share > 0.0 && out.share < 1.0;
}

// Calls back (seam, shell beyond it, share of its first edge) for each seam at this exit.
template <class F>
void each_seam(const std::vector<Seam>& seams, int shell, const EdgeExit& exit, F&& callback) {
  for (const Seam& seam : seams) {
    const bool first = seam.first == shell && seam.first_edge == exit.edge;
    if (!first && !(seam.second == shell && seam.second_edge == exit.edge)) continue;
    callback(seam, first ? seam.second : seam.first, first || !seam.reversed ? exit.share : 1.0 - exit.share);
  }
}

// Calls back (seam, shares of its first edge) for each seam that a crack edge is near. Near means that the edge lies
// between the seam and the control points beside it. The shares bound the part of the seam beside the edge.
template <class F>
void each_seam_beside(const std::vector<Seam>& seams, int shell, const ShellModel& m, const CrackEdge& e,
                      F&& callback) {
  for (const Seam& seam : seams)
    for (const bool first : {true, false}) {
      if (seam.trimmed() || (first ? seam.first : seam.second) != shell) continue;
      const int edge = first ? seam.first_edge : seam.second_edge, across = edge < kVMin ? 0 : 1;
      const KnotVector &over = across == 0 ? m.patch.knots_u : m.patch.knots_v,
                       &along = across == 0 ? m.patch.knots_v : m.patch.knots_u;
      const double border = edge == kUMin || edge == kVMin ? over.begin() : over.end();
      const double reach = std::abs(m.parameter[edge_row(m.patch, edge, 1)[0]][across] - border);
      if (std::min(std::abs(e.a[across] - border), std::abs(e.b[across] - border)) > reach) continue;
      const auto share = [&](double at) {
        const double own = (at - along.begin()) / (along.end() - along.begin());
        return !first && seam.reversed ? 1.0 - own : own;
      };
      const double pad =
          kSeamPad * m.spacing / (along.end() - along.begin());  // visibility is blocked just beyond an end, too
      const double a = share(e.a[1 - across]), b = share(e.b[1 - across]);
      callback(seam, std::min(a, b) - pad, std::max(a, b) + pad);
    }
}

// Returns unit vectors of the surface at rest at a point of an edge: along the edge, and into the patch.
void frame(int edge, const SurfacePoint& x, Vec3& along, Vec3& inward) {
  along = (edge < kVMin ? x.v : x.u).normalized();
  inward = edge < kVMin ? x.u : x.v;
  if (edge == kUMax || edge == kVMax) inward = -inward;
  inward = (inward - inward.dot(along) * along).normalized();
}

}  // namespace

int propagate_over_seams(const std::vector<Seam>& seams, const std::vector<ShellRef>& shells,
                         const std::vector<char>& can_crack, Stitching& stitching, double time) {
  int count = 0;
  for (int k = 0; k < static_cast<int>(shells.size()); ++k) {
    const ShellModel& m = *shells[k].model;
    for (std::size_t i = 0; i < shells[k].state->cracks.tips.size(); ++i) {
      Tip& tip = shells[k].state->cracks.tips[i];
      if (tip.alive || tip.seam_decided || tip.edge < 0) continue;
      tip.seam_decided = true;
      const CrackEdge& last = shells[k].state->cracks.graph.edges()[tip.edge];
      const Tip from = tip;  // a copy, since tips are added below
      const Vec2 before = from.vertex == last.to ? last.a : last.b;
      EdgeExit exit;
      const bool leaves = exit_of(m, before, from.p, exit);
      count += propagate_over_trims(seams, shells, can_crack, k, from, leaves ? exit.at : from.p,
                                    (from.p - before).normalized(), time);
      if (!leaves) continue;
      each_seam(seams, k, exit, [&](const Seam& seam, int other, double) {
        if (!can_crack[other]) return;
        const ShellModel& n = *shells[other].model;
        const int edge = other == seam.second ? seam.second_edge : seam.first_edge;
        const Vec2 at = edge_point(n.patch, edge, seam.reversed ? 1.0 - exit.share : exit.share);
        const SurfacePoint here = m.patch.evaluate(exit.at), there = n.patch.evaluate(at);
        Vec3 along, inward, along_there, inward_there;
        frame(exit.edge, here, along, inward), frame(edge, there, along_there, inward_there);
        const Vec3 d = (exit.direction.x() * here.u + exit.direction.y() * here.v).normalized();
        const Vec3 way_on = d.dot(along) * along - d.dot(inward) * inward_there;  // keeps the angle to the seam
        Eigen::Matrix<double, 3, 2> tangents;
        tangents << there.u, there.v;
        const Vec2 way = (tangents.transpose() * tangents).ldlt().solve(tangents.transpose() * way_on).normalized();
        start_beyond(n, *shells[other].state, at, kFirstEdge * n.spacing * way, from, (from.p - exit.at).norm(), time);
        ++count;
      });
    }
  }
  // Cracks of any origin release what a seam joins across them, also cracks that have just crossed one.
  const std::vector<int> seen_before(stitching.edges_seen().begin(), stitching.edges_seen().end());
  bool parted = false;
  for (int k = 0; k < static_cast<int>(shells.size()); ++k) {
    const auto& edges = shells[k].state->cracks.graph.edges();
    std::int64_t& seen = stitching.edges_seen()[k];
    for (; seen < static_cast<std::int64_t>(edges.size()); ++seen) {
      const CrackEdge& e = edges[seen];
      each_seam_beside(seams, k, *shells[k].model, e, [&](const Seam& seam, double low, double high) {
        stitching.release_beside(shells, seam, k, low, high), parted = true;
      });
      for (const bool back : {true, false}) {
        EdgeExit exit;
        if (!exit_of(*shells[k].model, back ? e.b : e.a, back ? e.a : e.b, exit)) continue;
        each_seam(seams, k, exit,
                  [&](const Seam& seam, int, double share) { stitching.part(shells, seam, share), parted = true; });
      }
    }
  }
  if (parted) stitching.release_corners(shells, seams);
  stitching.renew_ties(shells, seams, seen_before);
  return count;
}

void start_beyond(const ShellModel& n, ShellState& s, const Vec2& at, const Vec2& edge, const Tip& from, double behind,
                  double time) {
  const int before = static_cast<int>(s.cracks.graph.edges().size());
  insert_polyline(n, s, {at, at + edge}, time);
  const std::size_t first = s.cracks.tips.size();
  start_at_ends(n, s, before, static_cast<int>(s.cracks.graph.edges().size()));
  for (std::size_t t = first; t < s.cracks.tips.size(); ++t) {
    Tip& on = s.cracks.tips[t];
    // it has run on at once, and waits as long as that would have taken it
    on.pending = -edge.norm() - behind;
    // shorter than a whole crack: no less so; else it may turn as sharply as one that starts, which rights the
    // edge that it has run blindly
    if (from.grown < kWholeCrack * from.flaw)
      on.strength = from.strength, on.flaw = from.flaw, on.grown = from.grown, on.since_branch = from.since_branch;
  }
}

void release_seams(const std::vector<Seam>& seams, const std::vector<ShellRef>& shells, Stitching& stitching, int shell,
                   int edge, double from, double to) {
  constexpr double kAtEnds = 1e-9;  // share of the edge: round-off
  for (const Seam& seam : seams) {
    const bool first = seam.first == shell && seam.first_edge == edge;
    if (!first && !(seam.second == shell && seam.second_edge == edge)) continue;
    const bool back = !first && seam.reversed;
    stitching.open(shells, seam, (back ? 1.0 - to : from) - kAtEnds, (back ? 1.0 - from : to) + kAtEnds);
  }
  stitching.release_corners(shells, seams);
}

}  // namespace sunder::shell
