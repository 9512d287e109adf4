#pragma once
// What cracks have left of a patch.
#include <array>
#include <span>
#include <vector>

#include "shell/fracture/triangulation.h"
#include "shell/solver/state.h"

namespace sunder::shell {

struct Piece {
  int number = 0;     // in the triangulation
  double area = 0.0;  // at rest [m^2]
  std::vector<int> control_points;
  bool held = false;         // a support holds it
  bool gone = false;         // handed off before
  bool parted = false;       // a crack along a clamped border has parted some of it from there
  bool interlocked = false;  // still fastened to another piece
};

/// All of a patch, in its parameters.
Eigen::AlignedBox2d domain_of(const ShellModel& model);
/// The present cracks, with knots in these boxes; control points are the queries.
/// A border control point from which a crack along a clamp has parted the patch is in no piece.
Triangulation triangulated(const ShellModel& model, const ShellState& state,
                           std::span<const Eigen::AlignedBox2d> knots_in);
/// The pieces of a triangulation as they are held, fastened and gone now.
std::vector<Piece> pieces_of(const ShellModel& model, const ShellState& state, const Triangulation& t);
/// Both.
inline Triangulation partition(const ShellModel& model, const ShellState& state, std::vector<Piece>& pieces) {
  Triangulation t = triangulated(model, state, std::array{domain_of(model)});
  pieces = pieces_of(model, state, t);
  return t;
}

}  // namespace sunder::shell
