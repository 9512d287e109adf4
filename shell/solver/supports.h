#pragma once
// How a shell is held: control points that do not move along some axes, move as prescribed, or move together.
#include <array>
#include <vector>

#include "shell/geometry/edges.h"

namespace sunder::shell {

/// Corners of a patch as bits.
enum CornerBit { kUMinVMin = 1, kUMaxVMin = 2, kUMinVMax = 4, kUMaxVMax = 8 };

struct ParameterBox {
  Vec2 low, high;  // as in the scene's parameters [m]
};

struct Support {
  int edges = 0;
  bool clamped = true;                            // slope held too: two rows of control points
  std::array<bool, 3> axes = {true, true, true};  // x y z that are held
  int symmetry = -1;                              // 0 1 2: edges lie in a plane of symmetry across that axis
  int corners = 0;
  std::vector<ParameterBox> regions{};  // control points whose Greville points lie inside
  /// Displacement over time [s], [m], linear between; before and after as at the ends. Empty: does not move.
  std::vector<std::pair<double, Vec3>> motion{};
};

/// What supports come to, by axis. Sums of mass and force over a tied group move it as one.
struct Constraints {
  std::array<std::vector<int>, 3> held;               // slots that do not move along the axis
  std::array<std::vector<std::vector<int>>, 3> tied;  // slots that move together along it
  struct Driven {
    std::array<std::vector<int>, 3> slots;
    std::vector<std::pair<double, Vec3>> motion;
    Vec3 displacement(double time) const;
  };
  std::vector<Driven> driven;
  std::vector<int> anchors;  // slots that hold a piece; the second row of a clamped edge only gives its slope
  bool partial = false;      // anything but control points that are held altogether
};

/// A control point that one support holds and another moves along an axis is held. Throws Error where a symmetry edge
/// does not lie in a plane across its axis, or a region holds no control point.
Constraints make_constraints(const Patch& patch, const std::vector<Support>& supports, int stride,
                             const std::string& name);

}  // namespace sunder::shell
