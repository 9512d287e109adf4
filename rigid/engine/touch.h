#pragma once
// Points where two convex parts are nearest, or overlap least. The contact finders of engines report overlaps only, or
// use rounded shapes. A window needs contacts before the bodies meet.
#include <vector>

#include "rigid/engine/hulls.h"

namespace sunder::rigid {

/// A point of each part, in world coordinates [m]. gap = normal . (first - second) [m], negative in an overlap.
struct Touch {
  Vec3 first, second;
  Vec3 normal;  // from the second to the first
  double gap = 0.0;
};

/// Adds each corner of the part within `reach` [m] of the half space below normal . x = offset.
void touch_half_space(const Hull& part, const Vec3& normal, double offset, double reach, std::vector<Touch>& out);

/// Adds points where the parts are within `reach` [m]: up to four of a face, and one of two edges.
void touch_hulls(const Hull& first, const Hull& second, double reach, std::vector<Touch>& out);

}  // namespace sunder::rigid
