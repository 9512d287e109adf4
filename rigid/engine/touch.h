#pragma once
// Where two convex parts are nearest, or overlap least.
// The colliders of engines report overlaps only, or rounded shapes; a window has to know beforehand what it would run
// into.
#include <vector>

#include "rigid/engine/hulls.h"

namespace sunder::rigid {

/// A point of each part, in the world [m]. gap = normal . (first - second), negative where they overlap.
struct Touch {
  Vec3 first, second;
  Vec3 normal;  // from the second to the first
  double gap = 0.0;
};

/// Adds every corner of the part that is nearer than `reach` to the half space below normal . x = offset.
void touch_half_space(const Hull& part, const Vec3& normal, double offset, double reach, std::vector<Touch>& out);

/// Adds up to four points at which the parts are nearer than `reach`.
void touch_hulls(const Hull& first, const Hull& second, double reach, std::vector<Touch>& out);

}  // namespace sunder::rigid
