#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "shell/fracture/medial_axis.h"
#include "shell/solver/cracking/damage_lattice.h"
#include "tests/shell/damaging_panel.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(MedialAxis, OfABandIsItsMiddleAndOfATeeHasOneJunction) {
  const ShellModel m = panel(50, 0.2);
  const double cell = 0.5 * m.spacing;
  const auto axis_of = [&](const std::function<bool(const Vec2&)>& inside) {
    ShellState s = damaging(m);
    damage_where(m, s, inside);
    const DamageLattice grid(m, s, 0.0);
    return medial_axis(grid.boundary(), [&](const Vec2& p) { return grid.damaged(p); });
  };
  const auto band = [&](const Vec2& p) { return std::abs(p.y() - 0.15) < 4.0 * cell && p.x() > 0.03 && p.x() < 0.27; };
  const MedialAxis straight = axis_of(band);
  const auto lines = polylines(straight, 10.0 * cell);
  ASSERT_EQ(lines.size(), 1u);
  for (const int v : lines[0]) EXPECT_NEAR(straight.vertices[v].y(), 0.15, 0.51 * cell);
  const Vec2 first = straight.vertices[lines[0].front()], last = straight.vertices[lines[0].back()];
  EXPECT_NEAR(first.x() + last.x(), 0.3, 2.0 * cell);
  EXPECT_GT((first - last).norm(), 0.24 - 10.0 * cell);  // but for half the breadth at both ends
  const MedialAxis branched = axis_of(
      [&](const Vec2& p) { return band(p) || (std::abs(p.x() - 0.15) < 4.0 * cell && p.y() >= 0.15 && p.y() < 0.27); });
  const auto three = polylines(branched, 10.0 * cell);
  ASSERT_EQ(three.size(), 3u);
  std::map<int, int> ends;
  for (const auto& line : three) ++ends[line.front()], ++ends[line.back()];
  int junctions = 0;
  for (const auto& [v, count] : ends)
    if (count == 3) {
      ++junctions;
      EXPECT_LT((branched.vertices[v] - Vec2(0.15, 0.15)).norm(), 4.0 * cell);
    }
  EXPECT_EQ(junctions, 1);
}

TEST(MedialAxis, DoesNotComeBackBesideAnEarlierCrack) {
  std::vector<BoundarySample> seeds;
  for (double x = 0.1; x < 0.9; x += 0.02)
    for (const double side : {-1.0, 1.0}) seeds.push_back({Vec2(x, 0.5 + 0.03 * side), Vec2(0, side), side < 0.0});
  EXPECT_TRUE(medial_axis(seeds, [](const Vec2&) { return true; }).edges.empty());
}
