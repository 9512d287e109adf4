#pragma once
// A point of a soft surface that presses on something: what projected Gauss-Seidel does with it.
#include <algorithm>

#include "coupler/core/vec.h"

namespace sunder::shell {

constexpr int kPressSweeps = 20;                // of Gauss-Seidel, at most
constexpr double kPressSettled = 1e-10;         // change of the impulses in a sweep, of their sum, at which it ends
constexpr double kPressRecovery = 0.1;          // of an overlap, taken back in a step of the soft bodies
constexpr double kFastestPressRecovery = 0.01;  // [m/s], as a shell's
constexpr double kPressWatch = 0.02;  // of a grid spacing: what comes so near may be pushed in by its neighbours

/// Least normal velocity [m/s] afterwards: a gap [m] may close until contact is looked at again, `ahead` [s] from now;
/// `share` of an overlap is taken back in a step of `dt` [s].
inline double wanted_velocity(double gap, double ahead, double dt, double share) {
  return gap > 0.0 ? -gap / ahead : std::min(share * -gap / dt, kFastestPressRecovery);
}

/// Takes the impulse [N s] so far to the one by which the relative velocity `rel` leaves along `normal` as `wanted`,
/// with Coulomb's friction, and returns the change. `along`: change of the normal velocity per impulse, `across` of
/// both others together [1/kg], so that friction never overshoots.
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
