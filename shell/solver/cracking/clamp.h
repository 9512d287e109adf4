#pragma once
// Cracks along a clamped border. A clamped plate is bent most at its border and breaks there. But an element has one
// curvature, so which of its Gauss points exceeds the strength does not tell where in the element. Cracks that start or
// run beside a clamped border therefore run on it, and leave no strip.
#include <optional>

#include "shell/fracture/triangulation.h"
#include "shell/solver/state.h"

namespace sunder::shell {

static_assert(kOnBorder < kBorderTolerance);  // no piece is left between crack and border

struct ClampedBorder {
  Vec2 foot;   // nearest to the point, kOnBorder inside
  Vec2 along;  // unit vector, in the sense of the direction
};

/// The clamped border that a tip at p follows: one no further than `reach` [m] from p, or beyond which p lies, that
/// `direction` (unit vector) is nearly parallel to and does not leave.
std::optional<ClampedBorder> clamped_border(const ShellModel& model, const Vec2& p, const Vec2& direction,
                                            double reach);

/// The clamped border on which a line at p along `along` (unit vector, either way) starts: one that p sees within a
/// spacing and that is nearly parallel.
std::optional<ClampedBorder> clamped_start(const ShellModel& model, const CrackGraph& cracks, const Vec2& p,
                                           const Vec2& along);

/// The point where a crack through `p` along `way` (unit vector) meets the line of a clamped border; nothing if it is
/// more than `reach` [m] from the foot.
std::optional<Vec2> met_at(const ClampedBorder& border, const Vec2& p, const Vec2& way, double reach);

/// The control point inside, next to a control point of a clamped border from which a crack along it has parted the
/// patch. -1 for all others, and where an interlayer still hangs on the border.
int parted_from_clamp(const ShellModel& model, const CrackGraph& cracks, int control_point);

}  // namespace sunder::shell
