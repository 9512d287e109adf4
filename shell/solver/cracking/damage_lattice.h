#pragma once
// The Gauss points of a patch as cells of a lattice over its parameter domain, and where they are or were fully
// damaged.
#include "shell/fracture/medial_axis.h"
#include "shell/solver/state.h"

namespace sunder::shell {

struct DamageLattice {
  enum Cell : char { kSound, kDamaged, kSpent };  // spent: it belongs to a crack beside it

  const ShellModel* model;
  int columns, rows;
  std::vector<Cell> cells;  // whether any layer, or the fibre on either side, was ever fully damaged
  std::vector<char> now;    // whether it is fully damaged at present, or rubble

  /// Damaged cells nearer than `spent` [m] to a crack belong to that crack.
  DamageLattice(const ShellModel& model, const ShellState& state, double spent);

  std::size_t at(int i, int j) const { return static_cast<std::size_t>(j) * columns + i; }
  bool holds(int i, int j) const { return i >= 0 && j >= 0 && i < columns && j < rows; }
  /// Parameter point of a cell's lower left corner, and of its middle.
  Vec2 corner(int i, int j) const;
  Vec2 centre(int i, int j) const { return 0.5 * (corner(i, j) + corner(i + 1, j + 1)); }
  /// Cell of a point, -1 outside the patch; i and j get its column and row.
  int cell_of(const Vec2& p, int& i, int& j) const;
  bool damaged(const Vec2& p) const;
  /// Share of the cells on the straight way from a to b that were ever fully damaged.
  double damaged_share(const Vec2& a, const Vec2& b) const;
  /// Share of the cells within kBroadWindow of the cell of `p` that are fully damaged at present.
  double breadth(const Vec2& p) const;
  /// Middles of the sides between damaged cells and others, with normals of the blurred region.
  std::vector<BoundarySample> boundary() const;
};

}  // namespace sunder::shell
