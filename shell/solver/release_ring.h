#pragma once
// What the energy release of a tip looks at: the Gauss points around it, with all that stays while the tip does.
#include <array>
#include <vector>

#include "shell/mechanics/gathered_point.h"

namespace sunder::shell {

/// Where an energy release is asked for: parameters [m], a unit vector, and the radii [m] between which the virtual
/// advance falls from one to zero.
struct ReleaseLook {
  Vec2 tip = Vec2::Zero(), direction = Vec2::Zero();
  double inner = 0.0, outer = -1.0;

  bool operator==(const ReleaseLook&) const = default;
};

/// The virtual advance at a point: chi, its first and its second derivatives.
struct VirtualAdvance {
  double value = 1.0;
  Vec2 slope = Vec2::Zero();
  double uu = 0.0, vv = 0.0, uv = 0.0;
};

/// Not part of checkpoints: it can be found again.
struct ReleaseRing {
  struct Point {
    GatheredPoint own;  // functions and forms at rest
    int gathered = -1;  // its number among the gathered points; -1: the rows sum it
    Vec2 offset;        // from the tip [m]
    VirtualAdvance chi;
    // Of an advance along the direction, and of one across it: contravariant components at rest, and the component
    // along the normal.
    std::array<Vec2, 2> along;
    std::array<double, 2> up{};
  };
  ReleaseLook look;
  int edges = 0;  // of the crack graph at that time
  std::vector<Point> points;
};

}  // namespace sunder::shell
