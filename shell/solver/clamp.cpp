#include "shell/solver/clamp.h"

#include <cmath>

#include "shell/geometry/edges.h"

namespace sunder::shell {
namespace {

constexpr double kNear = 1.0;  // spacings: what an element that is bent quadratically cannot tell
constexpr double kParallel = 0.85;  // cosine, as of cracks that shield one another
constexpr double kAway = 0.3;      // sine: a step between two directions that a tip tries

struct Border {
  int axis;         // across it
  double at, sign;  // where it lies; inwards
};

Border border_of(const Patch& p, int edge) {
  const int axis = edge < kVMin ? 0 : 1;
  const KnotVector& k = axis == 0 ? p.knots_u : p.knots_v;
  const bool low = edge == kUMin || edge == kVMin;
  return {axis, low ? k.begin() : k.end(), low ? 1.0 : -1.0};
}

}  // namespace

std::optional<ClampedBorder> clamped_border(const ShellModel& m, const Vec2& p, const Vec2& direction) {
  for (const int edge : kEdges) {
    if (!(m.clamped & edge)) continue;
    const Border b = border_of(m.patch, edge);
    const double inwards = b.sign * direction[b.axis], along = direction[1 - b.axis];
    if (b.sign * (p[b.axis] - b.at) >= kNear * (b.axis == 0 ? m.spacing_u : m.spacing_v) ||
        std::abs(along) < kParallel || inwards > kAway)
      continue;
    ClampedBorder out{p, Vec2::Zero()};
    out.foot[b.axis] = b.at + b.sign * kOnBorder * m.spacing;
    out.along[1 - b.axis] = along < 0.0 ? -1.0 : 1.0;
    return out;
  }
  return std::nullopt;
}

bool parted_from_clamp(const ShellModel& m, const CrackGraph& cracks, int control_point) {
  const Vec2& p = m.parameter[control_point];
  for (const int edge : kEdges) {
    if (!(m.clamped & edge)) continue;
    const Border b = border_of(m.patch, edge);
    if (std::abs(p[b.axis] - b.at) > kOnBorder * m.spacing) continue;
    Vec2 q = p;
    q[b.axis] += b.sign * 2.0 * kOnBorder * m.spacing;
    if (!cracks.visible(p, q)) return true;
  }
  return false;
}

}  // namespace sunder::shell
