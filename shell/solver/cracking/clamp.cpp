#include "shell/solver/cracking/clamp.h"

#include <cmath>

#include "shell/geometry/edges.h"

namespace sunder::shell {
namespace {

struct Border {
  int axis;         // across the border
  double at, sign;  // its coordinate; sign of the inward direction
};

Border border_of(const Patch& p, int edge) {
  const int axis = edge < kVMin ? 0 : 1;
  const KnotVector& k = axis == 0 ? p.knots_u : p.knots_v;
  const bool low = edge == kUMin || edge == kVMin;
  return {axis, low ? k.begin() : k.end(), low ? 1.0 : -1.0};
}

}  // namespace

std::optional<ClampedBorder> clamped_border(const ShellModel& m, const Vec2& p, const Vec2& direction, double reach) {
  for (const int edge : kEdges) {
    if (!(m.clamped & edge)) continue;
    const Border b = border_of(m.patch, edge);
    const double inwards = b.sign * direction[b.axis], along = direction[1 - b.axis];
    if (b.sign * (p[b.axis] - b.at) > reach || std::abs(along) < kParallelCosine || inwards > kLeavesClamp) continue;
    ClampedBorder out{p, Vec2::Zero()};
    out.foot[b.axis] = b.at + b.sign * kOnBorder * m.spacing;
    out.along[1 - b.axis] = along < 0.0 ? -1.0 : 1.0;
    return out;
  }
  return std::nullopt;
}

std::optional<ClampedBorder> clamped_start(const ShellModel& m, const CrackGraph& cracks, const Vec2& p,
                                           const Vec2& along) {
  for (const double sign : {1.0, -1.0}) {
    const auto border = clamped_border(m, p, sign * along, m.spacing);
    if (border && cracks.visible(p, border->foot)) return border;
  }
  return std::nullopt;
}

std::optional<Vec2> met_at(const ClampedBorder& border, const Vec2& p, const Vec2& way, double reach) {
  const int axis = border.along.x() == 0.0 ? 0 : 1;
  Vec2 out = p + (border.foot[axis] - p[axis]) / way[axis] * way;
  out[axis] = border.foot[axis];
  if (!((out - border.foot).norm() <= reach)) return std::nullopt;
  return out;
}

int parted_from_clamp(const ShellModel& m, const CrackGraph& cracks, int control_point) {
  if (m.laminated()) return -1;
  const Vec2& p = m.parameter[control_point];
  for (const int edge : kEdges) {
    if (!(m.clamped & edge)) continue;
    const Border b = border_of(m.patch, edge);
    if (std::abs(p[b.axis] - b.at) > kOnBorder * m.spacing) continue;
    Vec2 q = p;
    q[b.axis] += b.sign * 2.0 * kOnBorder * m.spacing;
    if (!cracks.visible(p, q)) return control_point + (b.axis == 0 ? 1 : m.patch.columns()) * static_cast<int>(b.sign);
  }
  return -1;
}

}  // namespace sunder::shell
