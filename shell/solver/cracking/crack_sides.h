#pragma once
// The surface beside cracks, as it is drawn: each side has its own points, with the functions that see that side alone.
#include <array>
#include <vector>

#include "shell/fracture/triangulation.h"
#include "shell/solver/model.h"
#include "shell/solver/state.h"

namespace sunder::shell {

/// A point of the middle surface: position [m], velocity [m/s], displacement [m].
struct SidePoint {
  Vec3 x, v, u;
};

/// Evaluates a surface point with the functions of its own side of the cracks. `near_crack`: within two spacings of
/// one.
SidePoint side_point(const ShellModel& model, const ShellState& state, const Vec2& parameter, bool near_crack);

/// Corners of a triangulation. A vertex on a crack is one for each fan of connected triangles around it.
struct SideCorners {
  struct Corner {
    Vec2 at;    // parameter [m]: of the vertex, or near a crack a hundredth of the way into its fan
    bool near;  // a crack
  };
  std::vector<std::array<int, 3>> of;  // corner of each triangle's vertices
  std::vector<Corner> corners;
};
/// The interlayer of a laminated shell is continuous, so nothing is near a crack there.
SideCorners side_corners(const ShellModel& model, const ShellState& state, const Triangulation& t);

}  // namespace sunder::shell
