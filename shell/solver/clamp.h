#pragma once
// Cracks along a clamped border. A clamped plate is bent most at its very border, and breaks there, but stress is known
// no nearer to it than at the outermost Gauss points: cracks that start or run beside it run on it, and leave nothing.
#include <optional>

#include "shell/solver/state.h"

namespace sunder::shell {

/// A crack along a clamped border lies as far inside as this, where the border's control points are out of sight [of a
/// spacing].
constexpr double kOnBorder = 5e-4;

struct ClampedBorder {
  Vec2 foot;   // of the point, at kOnBorder
  Vec2 along;  // unit vector, as the direction has it
};

/// The clamped border less than half a spacing from p, or beyond which p lies, that a crack from there along
/// `direction` (unit vector) would follow: nearly parallel to it, and not away from it.
std::optional<ClampedBorder> clamped_border(const ShellModel& model, const Vec2& p, const Vec2& direction);

/// Whether a crack along the border has parted the patch from the support at a control point of a clamped border.
bool parted_from_clamp(const ShellModel& model, const CrackGraph& cracks, int control_point);

}  // namespace sunder::shell
