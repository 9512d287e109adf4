// Gauss points as cells: where the patch was fully damaged.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "shell/solver/cracking/damage_lattice.h"
#include "shell/solver/cracking/polyline.h"
#include "tests/shell/damaging_panel.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

/// A band of four rows of cells across a panel of 0.3 m with 30 elements, 60 cells, a side.
constexpr double kCell = 0.005, kLow = 28 * kCell, kHigh = 32 * kCell;
bool in_band(const Vec2& p) { return p.y() > kLow && p.y() < kHigh; }

}  // namespace

TEST(DamageLattice, HasACellForEachGaussPoint) {
  const ShellModel m = panel(30, 0.2);
  ShellState s = damaging(m);
  const DamageLattice grid(m, s, 0.0);
  EXPECT_EQ(grid.columns * grid.rows, m.tables.gauss_points());
  for (int j = 0; j < grid.rows; ++j)
    for (int i = 0; i < grid.columns; ++i) {
      int column = -1, row = -1;
      EXPECT_EQ(grid.cell_of(grid.centre(i, j), column, row), static_cast<int>(grid.at(i, j)));
      EXPECT_EQ(column, i);
      EXPECT_EQ(row, j);
    }
  int i, j;
  const Vec2 last(m.patch.knots_u.end(), m.patch.knots_v.end());
  for (const Vec2& outside : {Vec2(-1e-9, 0.1), Vec2(0.1, 0.3 + 1e-9)}) EXPECT_EQ(grid.cell_of(outside, i, j), -1);
  EXPECT_EQ(grid.cell_of(last, i, j), m.tables.gauss_points() - 1);  // the border is inside
  for (int q = 0; q < m.tables.blocks(); q += 7)
    for (int lane = q % 5; lane < m.tables.spans_u; lane += 11) {
      ShellState one = damaging(m);
      const Vec2 p = gauss_point(m.patch, m.tables, q, lane).parameter;
      damage_where(m, one, [&](const Vec2& at) { return at == p; });
      const DamageLattice hit(m, one, 0.0);
      EXPECT_TRUE(hit.damaged(p)) << p.transpose();
      EXPECT_EQ(std::count(hit.cells.begin(), hit.cells.end(), DamageLattice::kDamaged), 1);
    }
}

TEST(DamageLattice, TellsShareAndBreadthOfABand) {
  const ShellModel m = panel(30, 0.2);
  ShellState s = damaging(m);
  damage_where(m, s, in_band);
  const DamageLattice grid(m, s, 0.0);
  EXPECT_EQ(std::count(grid.cells.begin(), grid.cells.end(), DamageLattice::kDamaged), 4 * 60);
  EXPECT_EQ(grid.damaged_share({0.05, 0.15}, {0.25, 0.15}), 1.0);
  EXPECT_EQ(grid.damaged_share({0.05, 0.05}, {0.25, 0.05}), 0.0);
  // straight through: of 0.24 m it is 0.02 m within, by steps of a quarter of a spacing
  EXPECT_NEAR(grid.damaged_share({0.15, 0.03}, {0.15, 0.27}), 0.02 / 0.24, 0.02);
  EXPECT_NEAR(grid.breadth({0.15, 29.5 * kCell}), 4.0 / 7.0, 1e-12);
  EXPECT_EQ(grid.breadth({0.15, 0.03}), 0.0);
  EXPECT_EQ(grid.breadth({-1.0, 0.0}), 0.0);
  for (PointDamage& d : s.cracked.damage) d.now.fill(0.0f);  // healed
  const DamageLattice healed(m, s, 0.0);
  EXPECT_EQ(healed.breadth({0.15, 29.5 * kCell}), 0.0);
  EXPECT_TRUE(healed.damaged({0.15, 29.5 * kCell}));  // it was once
}

TEST(DamageLattice, BoundaryLooksOutwardsAndKnowsWhatOlderCracksHave) {
  const ShellModel m = panel(30, 0.2);
  ShellState s = damaging(m);
  damage_where(m, s, in_band);
  const std::vector<BoundarySample> fresh = DamageLattice(m, s, 0.0).boundary();
  EXPECT_EQ(fresh.size(), 120u);  // two sides of 60 cells
  for (const BoundarySample& b : fresh) {
    EXPECT_FALSE(b.historical);
    EXPECT_NEAR(b.p.y(), b.outward.y() > 0.0 ? kHigh : kLow, 1e-12);
    EXPECT_GT(std::abs(b.outward.y()), 0.8);  // 0.85 at the border, 1 elsewhere
  }
  insert_polyline(m, s, {{0.0, 0.15}, {0.14, 0.15}}, 0.0);
  const DamageLattice grid(m, s, 2.5 * kCell);  // all of the band beside the crack is the crack's
  EXPECT_EQ(grid.cells[grid.at(5, 29)], DamageLattice::kSpent);
  EXPECT_EQ(grid.cells[grid.at(45, 29)], DamageLattice::kDamaged);
  const auto cut = grid.boundary();
  EXPECT_EQ(std::count_if(cut.begin(), cut.end(), [](const BoundarySample& b) { return b.historical; }), 4);
}
