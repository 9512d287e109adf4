#include "shell/solver/joining/seam_strength.h"

#include <algorithm>

#include "shell/geometry/quadrature.h"

namespace sunder::shell {
namespace {

constexpr double kSameShare = 1e-9;  // share of the edge: round-off

// Length of an edge that the function of each control point of its row stands for [m].
std::vector<double> lengths_along(const Patch& p, int edge) {
  const std::vector<int> row = edge_row(p, edge, 0);
  const KnotVector& along = edge < kVMin ? p.knots_v : p.knots_u;
  const GaussRule& rule = gauss_rule(p.degree() + 1);
  std::vector<double> lengths(row.size(), 0.0);
  for (int e = 0; e < along.spans(); ++e)
    for (int k = 0; k < p.degree() + 1; ++k) {
      const double t = (gauss_parameter(along, rule, e, k) - along.begin()) / (along.end() - along.begin());
      const Vec2 at = edge_point(p, edge, t);
      const SurfacePoint x = p.evaluate(at);
      const double length = 0.5 * along.span_length(e) * rule.weight[k] * (edge < kVMin ? x.v : x.u).norm();
      const ShapeFunctions n = p.shape_functions(at);
      for (int i = 0; i < n.count(); ++i) {
        const auto found = std::find(row.begin(), row.end(), n.row(i) * p.columns() + n.column(i));
        if (found != row.end()) lengths[found - row.begin()] += length * n.value[i];
      }
    }
  return lengths;
}

}  // namespace

SeamStrength::SeamStrength(const std::vector<Seam>& seams, const std::vector<const ShellModel*>& shells,
                           const Stitching& stitching) {
  for (std::size_t i = 0; i < seams.size(); ++i) {
    const Seam& seam = seams[i];
    if (seam.strength == 0.0 || seam.trimmed()) continue;
    for (const bool first : {false, true}) {  // the second shell depends on the first, but for its held ends
      const int k = first ? seam.first : seam.second, edge = first ? seam.first_edge : seam.second_edge;
      const ShellModel& m = *shells[k];
      const std::vector<int> row = edge_row(m.patch, edge, 0);
      const std::vector<double> lengths = lengths_along(m.patch, edge);
      const int axis = edge < kVMin ? 1 : 0;
      const KnotVector& along = axis == 1 ? m.patch.knots_v : m.patch.knots_u;
      const double response = std::max(shells[seam.first]->response_time(), shells[seam.second]->response_time());
      const std::size_t before = points_.size();
      for (std::size_t n = 1; n + 1 < row.size(); ++n) {  // corners open with the points beside them
        const int slot = m.tables.slot(row[n]);
        if (!stitching.is_dependent(k, slot)) continue;
        const double own = (m.parameter_of_slot[slot][axis] - along.begin()) / (along.end() - along.begin());
        points_.push_back({static_cast<int>(i), k, slot, m.mass[slot], seam.strength * lengths[n],
                           !first && seam.reversed ? 1.0 - own : own, response});
      }
      if (points_.size() > before) break;
    }
  }
}

void SeamStrength::store_forces(const std::vector<ShellRef>& shells) {
  for (Point& p : points_) p.force = shells[p.shell].state->at(shells[p.shell].state->motion.force, p.slot);
}

void SeamStrength::measure(const std::vector<ShellRef>& shells, double dt) {
  for (Point& p : points_) {
    if (!p.holds) continue;
    const Motion& motion = shells[p.shell].state->motion;
    // move_forces has left the force that makes it accelerate as what it depends on
    const Vec3 acceleration = motion.inverse_mass[p.slot] * shells[p.shell].state->at(motion.force, p.slot);
    const Vec3 now = p.mass * acceleration - p.force;
    p.mean += std::min(1.0, dt / p.response) * (now - p.mean);
  }
}

bool SeamStrength::open(const std::vector<ShellRef>& shells, const std::vector<Seam>& seams, Stitching& stitching) {
  bool any = false;
  for (Point& p : points_) {
    if (!p.holds || p.mean.norm() <= p.most) continue;
    p.holds = false;
    if (!stitching.is_dependent(p.shell, p.slot)) continue;  // a crack has released it before
    stitching.open(shells, seams[p.seam], p.share - kSameShare, p.share + kSameShare), any = true;
  }
  if (any) stitching.release_corners(shells, seams);
  return any;
}

}  // namespace sunder::shell
