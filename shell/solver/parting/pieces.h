#pragma once
// Pieces of a shell: the regions of a patch that cracks have separated.
#include <array>
#include <span>
#include <vector>

#include "shell/fracture/triangulation.h"
#include "shell/solver/state.h"

namespace sunder::shell {

/// One region of a patch between cracks.
struct Piece {
  int number = 0;     // in the triangulation
  double area = 0.0;  // at rest [m^2]
  std::vector<int> control_points;
  bool held = false;         // a support holds it
  bool handed_off = false;   // or never there
  bool outside = false;      // outside of the trim loops: it was never there
  bool parted = false;       // a crack along a clamped border has parted a piece of it from the border
  bool interlocked = false;  // crack faces in contact still join it to another piece
};

/// Returns the parameter domain of a patch.
Eigen::AlignedBox2d domain_of(const ShellModel& model);
/// Returns what frames show of a parameter [m]: its share of the domain, 0 to 1 along each direction, or the texture
/// coordinates that the model's mesh file has there.
Vec2 drawn_parameter(const ShellModel& model, const Vec2& parameter);
/// Returns the colour that the model's mesh file has at a parameter [m]; white where it has none.
Vec3 drawn_colour(const ShellModel& model, const Vec2& parameter);
/// Triangulates the patch with the present cracks, and with knots in the boxes `knots_in`; control points are assigned
/// to pieces. A border control point that a crack along a clamp has parted belongs to no piece.
Triangulation triangulated(const ShellModel& model, const ShellState& state,
                           std::span<const Eigen::AlignedBox2d> knots_in);
/// Returns the pieces of a triangulation with their present support, contact and hand-off.
std::vector<Piece> pieces_of(const ShellModel& model, const ShellState& state, const Triangulation& t);
/// Triangulates with all knots, and returns the pieces in `pieces`.
inline Triangulation partition(const ShellModel& model, const ShellState& state, std::vector<Piece>& pieces) {
  Triangulation t = triangulated(model, state, std::array{domain_of(model)});
  pieces = pieces_of(model, state, t);
  return t;
}

}  // namespace sunder::shell
