#pragma once
// Supports of a shell: control points that do not move along some axes, move as prescribed, or move together.
#include <array>
#include <limits>
#include <string>
#include <vector>

#include "shell/geometry/edges.h"

namespace sunder::shell {

/// Corners of a patch as bits.
enum CornerBit { kUMinVMin = 1, kUMaxVMin = 2, kUMinVMax = 4, kUMaxVMax = 8 };

/// A box in the parameters of a patch.
struct ParameterBox {
  Vec2 low, high;  // in the scene's parameters [m]
};

/// A box along the axes of the world [m].
struct SpaceBox {
  Vec3 low = Vec3::Constant(-std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(std::numeric_limits<double>::infinity());
};

/// A support as the scene gives it.
struct Support {
  int edges = 0;
  bool clamped = true;                            // the slope is held too, by the second row of control points
  std::array<bool, 3> axes = {true, true, true};  // axes x y z that are held
  int symmetry = -1;                              // 0 1 2: the edges lie in a symmetry plane across that axis; -1: none
  int corners = 0;
  std::vector<ParameterBox> regions{};  // control points with Greville points inside are held
  std::vector<SpaceBox> boxes{};        // control points whose places on the surface at rest lie inside are held
  /// [box]: these control points. make_shell() finds them, since they depend on what trims leave.
  std::vector<std::vector<int>> in_boxes{};
  /// Displacement over time [s], [m]: linear between points, constant outside. Empty: no motion.
  std::vector<std::pair<double, Vec3>> motion{};
  double until = std::numeric_limits<double>::infinity();  // released at this time [s]
};

/// The combined effect of all supports, by axis. Tied slots move as one, with the sums of their masses and forces.
struct Constraints {
  std::array<std::vector<int>, 3> held;               // slots that do not move along the axis
  std::array<std::vector<std::vector<int>>, 3> tied;  // slots that move together along it
  /// Control points that a support moves as prescribed.
  struct Driven {
    std::array<std::vector<int>, 3> slots;
    std::vector<std::pair<double, Vec3>> motion;
    /// Displacement [m] at `time` [s].
    Vec3 displacement(double time) const;
  };
  std::vector<Driven> driven;
  /// What one edge, one corner, one region or one box of a support holds or drives. A slot that several hold along an
  /// axis is in the first of them, in the order of supports, edges, corners, regions and boxes. A box without control
  /// points of this shell is no part.
  struct Part {
    std::string name;  // for example support_0_u_min, support_1_corner_u_min_v_max, support_2_region_0, support_3_box_0
    std::array<std::vector<int>, 3> slots;
  };
  std::vector<Part> parts;
  // slots that hold a piece; the second row of a clamped edge, which holds only the slope, is left out
  std::vector<int> anchors;
  bool partial = false;  // true where some control point is held along some axes only, tied or driven
};

/// Combines the supports that hold at `time` [s]. Parts are those of all supports; a released one has no slots. A
/// control point that one support holds and another moves along the same axis is held. Throws Error where a symmetry
/// edge does not lie in a plane across its axis or moves in two ways. Throws it too for a region without control
/// points.
Constraints make_constraints(const Patch& patch, const std::vector<Support>& supports, int stride,
                             const std::string& name, double time = 0.0);

}  // namespace sunder::shell
