#pragma once
// One contact point of a soft surface, as projected Gauss-Seidel solves it.
#include <algorithm>

#include "coupler/core/vec.h"

namespace sunder::shell {

constexpr int kPressSweeps = 20;                // largest number of Gauss-Seidel sweeps
constexpr double kPressSettled = 1e-10;         // sweeps end when impulses change by less than this share of their sum
constexpr double kPressRecovery = 0.1;          // share of an overlap that one step of the soft bodies takes back
constexpr double kFastestPressRecovery = 0.01;  // [m/s]; the same limit as for shells
constexpr double kPressWatch = 0.02;  // in grid spacings: a point this near may be pushed in by its neighbours

/// Returns the least normal velocity [m/s] that a contact point may have after contact. A gap [m] may close over
/// `ahead` [s], when contact is solved next. Of an overlap, `share` is taken back in a step of `dt` [s], no faster than
/// kFastestPressRecovery.
inline double wanted_velocity(double gap, double ahead, double dt, double share) {
  return gap > 0.0 ? -gap / ahead : std::min(share * -gap / dt, kFastestPressRecovery);
}

/// Updates the accumulated impulse [N s] of a contact point so that the relative velocity `rel` reaches `wanted` along
/// `normal` [m/s], with Coulomb friction. Returns the change of the impulse. `along` is the change of the normal
/// velocity per impulse [1/kg]. `across` is the sum of the two tangential ones [1/kg]; with the sum, friction never
/// overshoots.
inline Vec3 press(const Vec3& rel, const Vec3& normal, double wanted, double friction, double along, double across,
                  Vec3& impulse) {
  const double approach = rel.dot(normal), old = impulse.dot(normal);
  const double pushed = std::max(0.0, old + (wanted - approach) / along);
  Vec3 slide = impulse - old * normal - (rel - approach * normal) / across;
  const double most = friction * pushed, size = slide.norm();
  if (size > most) slide *= most / size;
  const Vec3 change = pushed * normal + slide - impulse;
  impulse += change;
  return change;
}

}  // namespace sunder::shell
