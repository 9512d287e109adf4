#pragma once
// Fits a spline to points of a surface whose parameters are known roughly.
#include <vector>

#include "shell/geometry/patch.h"

namespace sunder::shell {

/// A point that the spline is to pass.
struct FitPoint {
  Vec2 at = Vec2::Zero();  // parameters, first those of the caller, then those of the nearest place
  Vec3 x = Vec3::Zero();   // [m]
  double weight = 1.0;     // [-]
};

struct SurfaceFit {
  Patch patch;                   // over the rectangle from (0, 0) to `size`
  std::vector<FitPoint> points;  // with their nearest places
};

/// Least squares over splines of `elements` equal spans on a rectangle of `size` [m]. Third derivatives are
/// kept small, so that the surface goes on smoothly where there are no points: as a polynomial of degree 2
/// at most. Nearest places and splines are found in turn. Throws Error where the equations have no solution.
SurfaceFit fit_surface(std::vector<FitPoint> points, const Vec2& size, const std::array<int, 2>& elements, int degree);

/// The place of a patch nearest to x, by Newton's method from `start`. It stays within the patch.
Vec2 nearest_place(const Patch& patch, const Vec3& x, const Vec2& start);

}  // namespace sunder::shell
