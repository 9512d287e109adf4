#include "shell/solver/joining/trim_cracks.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "shell/fracture/constants.h"
#include "shell/solver/joining/seam_cracks.h"
#include "shell/solver/model.h"

namespace sunder::shell {
namespace {

// Whether the shell has a crack near p.
bool is_cracked(const ShellModel& m, const CrackGraph& cracks, const Vec2& p) {
  bool any = false;
  cracks.near(p, p, kCrossedBefore * m.spacing, [&](int e) {
    Vec2 foot;
    any = !cracks.edges()[e].is_trim() && cracks.distance(p, e, foot) < kCrossedBefore * m.spacing;
    return !any;
  });
  return any;
}

}  // namespace

std::optional<TrimFoot> foot_on_trim(const Seam& seam, const std::vector<ShellRef>& shells, bool first, const Vec2& p) {
  const int places = static_cast<int>(seam.places.size());
  const auto own = [&](int i) -> const Vec2& { return first ? seam.places[i].first : seam.places[i].second; };
  const auto other = [&](int i) -> const Vec2& { return first ? seam.places[i].second : seam.places[i].first; };
  int best = -1;
  double share = 0.0, away = 0.0;
  for (int i = 0; i < (seam.closed ? places : places - 1); ++i) {
    const Vec2 d = own((i + 1) % places) - own(i);
    // the first and the last place are half a length from the ends of the seam
    const double low = i == 0 && !seam.closed ? -0.6 : 0.0, high = i + 2 == places && !seam.closed ? 1.6 : 1.0;
    const double at = std::clamp((p - own(i)).dot(d) / std::max(d.squaredNorm(), 1e-300), low, high);
    const double distance = (p - own(i) - at * d).norm();
    if (best < 0 || distance < away) best = i, share = at, away = distance;
  }
  if (best < 0) return {};
  const int next = (best + 1) % places, nearest = share < 0.5 ? best : next;
  const ShellModel &m = *shells[first ? seam.first : seam.second].model,
                   &n = *shells[first ? seam.second : seam.first].model;
  TrimFoot foot;
  foot.away = away, foot.beyond = other(best) + share * (other(next) - other(best));
  const SeamPlace& place = seam.places[nearest];
  const SurfacePoint here = m.patch.evaluate(own(nearest));
  const Vec2 into = first ? place.into_first : place.into_second;
  foot.along = (m.patch.evaluate(own(next)).x - m.patch.evaluate(own(best)).x).normalized();
  foot.inward = (into.x() * here.u + into.y() * here.v).normalized();
  const double length = (n.patch.evaluate(other(next)).x - n.patch.evaluate(other(best)).x).norm();
  foot.along_beyond = (other(next) - other(best)) / std::max(length, 1e-300);
  foot.inward_beyond = first ? place.into_second : place.into_first;
  return foot;
}

int propagate_over_trims(const std::vector<Seam>& seams, const std::vector<ShellRef>& shells,
                         const std::vector<char>& can_crack, int shell, const Tip& tip, const Vec2& at,
                         const Vec2& direction, double time) {
  const ShellModel& m = *shells[shell].model;
  std::optional<TrimFoot> foot;
  int other = -1;
  for (const Seam& seam : seams)
    for (const bool first : {true, false}) {
      if (!seam.trimmed() || (first ? seam.first : seam.second) != shell) continue;
      const std::optional<TrimFoot> own = foot_on_trim(seam, shells, first, at);
      if (!own || own->away > kOnTrim * m.spacing || (foot && own->away >= foot->away)) continue;
      foot = own, other = first ? seam.second : seam.first;
    }
  if (!foot || can_crack[other] == 0) return 0;
  const ShellModel& n = *shells[other].model;
  ShellState& s = *shells[other].state;
  if (is_cracked(n, s.cracks.graph, foot->beyond)) return 0;
  const SurfacePoint here = m.patch.evaluate(at);
  const Vec3 d = (direction.x() * here.u + direction.y() * here.v).normalized();
  const double along = d.dot(foot->along), out = std::max(-d.dot(foot->inward), kLeastCrossing);
  const Vec2 way = (along * foot->along_beyond + out * foot->inward_beyond).normalized();
  const auto inside = [&](const Vec2& p) {
    return n.patch.contains(p) && (n.trim.empty() || n.trim.loops.contains(p));
  };
  double length = kFirstEdge * n.spacing;
  while (length > kShortestFirst * n.spacing && !inside(foot->beyond + length * way)) length *= 0.5;
  // The last edge has been cut once a whole one was due, whatever its length.
  const CrackEdge& last = shells[shell].state->cracks.graph.edges()[tip.edge];
  start_beyond(n, s, foot->beyond, length * way, tip, (last.b - last.a).norm() - kEdgeLength * m.spacing, time);
  return 1;
}

}  // namespace sunder::shell
