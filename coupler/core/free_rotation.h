#pragma once
// Rotation of a rigid body on which no moment acts.
#include "coupler/core/vec.h"

namespace sunder {

/// Orientation (body axes to world) after h seconds without a moment. In: principal moments of inertia [kg m^2], the
/// constant angular momentum in world axes [kg m^2/s], the orientation at the start. Exact where two moments are equal;
/// else of fourth order, with as many steps as the spin needs: an error of 1e-7 rad or less for each radian of turn. A
/// body that turns more than some 160 times in h takes the rest in one step: its orientation is then a valid one, and
/// no more.
Quat free_rotation(const Vec3& principal_inertia, const Vec3& angular_momentum, const Quat& start, double h);

}  // namespace sunder
