#pragma once
// Propagation of cracks over ties along trims.
#include <optional>

#include "shell/solver/joining/stitching.h"

namespace sunder::shell {

/// Where a point of a shell's border lies on a trimmed seam, and how the surface goes on beyond it.
struct TrimFoot {
  double away = 0.0;                                 // from the seam [m]
  Vec2 beyond = Vec2::Zero();                        // the same place in the other shell, in its parameters
  Vec3 along = Vec3::Zero(), inward = Vec3::Zero();  // unit vectors at rest: along the seam, and into the shell
  Vec2 along_beyond = Vec2::Zero(), inward_beyond = Vec2::Zero();  // the same two in the other shell, per metre
};

/// The place of a seam that is nearest to parameter p of one of its shells. Empty: the seam has but one place.
std::optional<TrimFoot> foot_on_trim(const Seam& seam, const std::vector<ShellRef>& shells, bool first, const Vec2& p);

/// Propagates a crack over the nearest trimmed seam on which its tip has ended. `shell`, `tip`: whose crack it is;
/// `at`: where it ends on the border; `direction`: of its last edge. The angle to the seam stays, and is at least
/// `kLeastCrossing`. Nothing starts where the other shell cannot crack (`can_crack`, by shell) or has a crack there.
/// Returns the number of cracks that crossed: 0 or 1.
int propagate_over_trims(const std::vector<Seam>& seams, const std::vector<ShellRef>& shells,
                         const std::vector<char>& can_crack, int shell, const Tip& tip, const Vec2& at,
                         const Vec2& direction, double time);

}  // namespace sunder::shell
