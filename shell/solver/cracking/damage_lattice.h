#pragma once
// The Gauss points of a patch as cells of a lattice over its parameter domain: where it was fully damaged.
#include "shell/fracture/medial_axis.h"
#include "shell/solver/state.h"

namespace sunder::shell {

struct DamageLattice {
  enum Cell : char { kSound, kDamaged, kSpent };  // spent: beside a crack, whose damage it is

  const ShellModel* model;
  int columns, rows;
  std::vector<Cell> cells;  // whether it was ever fully damaged, in any layer
  std::vector<char> now;    // it is fully damaged at present, or rubble

  /// Cells nearer than `spent` [m] to a crack are that crack's.
  DamageLattice(const ShellModel& model, const ShellState& state, double spent);

  std::size_t at(int i, int j) const { return static_cast<std::size_t>(j) * columns + i; }
  bool holds(int i, int j) const { return i >= 0 && j >= 0 && i < columns && j < rows; }
  /// Parameter point of a cell's lower left corner, and of its middle.
  Vec2 corner(int i, int j) const;
  Vec2 centre(int i, int j) const { return 0.5 * (corner(i, j) + corner(i + 1, j + 1)); }
  /// Cell of a point, -1 outside the patch; its column and row in i and j.
  int cell_of(const Vec2& p, int& i, int& j) const;
  bool damaged(const Vec2& p) const;
  /// Of the cells of a straight way from a to b, the share that was ever fully damaged.
  double damaged_share(const Vec2& a, const Vec2& b) const;
  /// Of the cells within three of that of `p`, the share that is fully damaged at present.
  double breadth(const Vec2& p) const;
  /// Middles of the sides between damaged cells and others, with normals of the blurred region.
  std::vector<BoundarySample> boundary() const;
};

}  // namespace sunder::shell
