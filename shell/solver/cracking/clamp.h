#pragma once
// Cracks along a clamped border. A clamped plate is bent most at its very border, and breaks there, but an element has
// one curvature: which of its Gauss points exceeds the strength does not tell where in it. Cracks that start or run
// beside a clamped border run on it, and leave nothing.
#include <optional>

#include "shell/fracture/triangulation.h"
#include "shell/solver/state.h"

namespace sunder::shell {

/// A crack along a clamped border lies as far inside as this, where the border's control points are out of sight
/// [spacings].
constexpr double kOnBorder = 5e-4;
static_assert(kOnBorder < kAtBorder);  // no piece is left between

struct ClampedBorder {
  Vec2 foot;   // of the point, kOnBorder inside
  Vec2 along;  // unit vector, as the direction has it
};

/// The clamped border no further than `reach` [m] from p, or beyond which p lies, that a tip there follows which runs
/// along `direction` (unit vector): nearly parallel to it, and not away from it.
std::optional<ClampedBorder> clamped_border(const ShellModel& model, const Vec2& p, const Vec2& direction,
                                            double reach);

/// The one on which a line at p along `along` (unit vector, either way) starts that is within a spacing of it, nearly
/// parallel and sees it.
std::optional<ClampedBorder> clamped_start(const ShellModel& model, const CrackGraph& cracks, const Vec2& p,
                                           const Vec2& along);

/// Where a crack through `p` along `way` (unit vector) meets the line of a clamped border; nothing beyond `reach` [m]
/// from the foot.
std::optional<Vec2> met_at(const ClampedBorder& border, const Vec2& p, const Vec2& way, double reach);

/// Of a control point of a clamped border from which a crack along it has parted the patch: the one beside it inside.
/// -1: of all others, and where an interlayer still hangs on the border.
int parted_from_clamp(const ShellModel& model, const CrackGraph& cracks, int control_point);

}  // namespace sunder::shell
