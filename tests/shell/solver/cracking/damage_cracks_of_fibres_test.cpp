// Cracks from the union of both phase fields: that of layers and that of fibres.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "shell/solver/cracking/damage_cracks.h"
#include "shell/solver/cracking/damage_lattice.h"
#include "tests/shell/torn_fibres.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// A band along x through the middle of the panel, as broad as a tear.
bool in_tear(const Vec2& p) { return std::abs(p.y() - 0.15) < 0.9 * 0.3 / 40.0; }
bool in_left_tear(const Vec2& p) { return in_tear(p) && p.x() < 0.15; }
bool in_right_tear(const Vec2& p) { return in_tear(p) && p.x() >= 0.15; }

void extract_all(const ShellModel& m, ShellState& s) {
  for (int k = 0; k < 3; ++k) extract_cracks(m, s, 0.0);
}

}  // namespace

TEST(FibreCracks, ABandThatBothFieldsShareIsCutAsThatOfOneField) {
  const ShellModel m = panel_with_fibres(40);
  ShellState whole = damaging(m);
  damage_where(m, whole, in_tear);
  extract_all(m, whole);
  const auto& expected = whole.cracks.graph.edges();
  ASSERT_GT(expected.size(), 20u);
  for (const std::size_t side : {0u, 1u}) {
    ShellState s = damaging(m);
    damage_where(m, s, in_left_tear);
    tear_fibres_where(m, s, side, in_right_tear);
    extract_all(m, s);
    const auto& edges = s.cracks.graph.edges();
    ASSERT_EQ(edges.size(), expected.size()) << side;
    for (std::size_t k = 0; k < edges.size(); ++k) {
      EXPECT_EQ(edges[k].a, expected[k].a) << k;
      EXPECT_EQ(edges[k].b, expected[k].b) << k;
    }
  }
}

TEST(FibreCracks, FibresAloneAreCutAlongTheirMiddleLine) {
  const ShellModel m = panel_with_fibres(40);
  ShellState s = damaging(m);
  tear_fibres_where(m, s, 1, in_right_tear);
  extract_all(m, s);
  ASSERT_GT(s.cracks.graph.edges().size(), 10u);
  EXPECT_GT(s.cracks.graph.total_length(), 0.12);
  for (const CrackEdge& e : s.cracks.graph.edges())
    for (const Vec2& p : {e.a, e.b}) {
      EXPECT_NEAR(p.y(), 0.15, 0.5 * m.spacing);
      EXPECT_GT(p.x(), 0.15 - 2.0 * m.spacing);  // its end may go on by an edge
    }
  for (double x = 0.17; x < 0.3; x += 0.01) EXPECT_FALSE(s.cracks.graph.visible({x, 0.05}, {x, 0.25})) << x;
  EXPECT_TRUE(s.cracks.graph.visible({0.1, 0.05}, {0.1, 0.25}));
  // layers were whole: the cut takes what they hold, which is nothing at rest
  for (const PointDamage& d : s.cracked.damage) EXPECT_EQ(d.worst(), 0.0f);
}

TEST(FibreCracks, DamageOfAPointIsTheLargestOfItsLayersAndItsFibres) {
  const ShellModel m = panel_with_fibres(30);
  ShellState s = damaging(m);
  const auto at = [&](int q, int e) { return static_cast<std::size_t>(q) * m.tables.lanes + e; };
  s.layers.through[2 * at(3, 4)] = 0.25f, s.layers.through_his[2 * at(3, 4)] = 0.5f;
  s.layers.through[2 * at(3, 4) + 1] = 0.125f, s.layers.through_his[2 * at(3, 4) + 1] = 0.75f;
  s.layers.through_his[2 * at(5, 6)] = 0.5f;  // healed: nothing lists it
  watch_stress(m, s);
  ASSERT_EQ(s.cracked.gathered.size(), 1u);
  EXPECT_TRUE(s.cracked.gathered[0].in_rows);  // the kernel of rows still sums it
  EXPECT_EQ(s.layers.c[at(3, 4)], 0.25f);
  EXPECT_EQ(s.layers.c_his[at(3, 4)], 0.75f);
  EXPECT_EQ(s.damage(0), 0.25f);
  s.cracked.damage[0].now[1] = s.cracked.damage[0].history[1] = 0.875f;
  watch_stress(m, s);
  EXPECT_EQ(s.layers.c[at(3, 4)], 0.875f);
  EXPECT_EQ(s.layers.c_his[at(3, 4)], 0.875f);
  EXPECT_EQ(std::count_if(s.layers.c.begin(), s.layers.c.end(), [](float c) { return c > 0.0f; }), 1);
}

TEST(FibreCracks, WhatHasHealedWasTornOnce) {
  const ShellModel m = panel_with_fibres(40);
  ShellState s = damaging(m);
  tear_fibres_where(m, s, 0, in_tear);
  const Vec2 middle(0.15, 0.15 + 0.25 * m.spacing);
  EXPECT_GT(DamageLattice(m, s, 0.0).breadth(middle), 0.5);
  std::fill(s.layers.through.begin(), s.layers.through.end(), 0.0f);
  watch_stress(m, s);
  const DamageLattice healed(m, s, 0.0);
  EXPECT_EQ(healed.breadth(middle), 0.0);
  EXPECT_TRUE(healed.damaged(middle));
  EXPECT_EQ(extract_cracks(m, s, 0.0), 0);  // a line goes through what is damaged now
}

// Fibres that may tear and do not leave the shell as it is, to the bit.
TEST(FibreCracks, WholeFibresChangeNothing) {
  ShellModel with = panel_with_fibres(40), without = with;
  without.fibres = {1e6, 1e5, 0.5};
  ShellState a = damaging(with), b = damaging(without);
  EXPECT_TRUE(b.layers.through.empty());
  for (int step = 1; step <= 12; ++step) {
    for (const auto& [m, s] : {std::pair{&with, &a}, std::pair{&without, &b}}) {
      stretch_x(*m, *s, 1e-4 * step);
      compute_forces(*m, *s, false, 1.0, 1);
      watch_stress(*m, *s);
    }
    EXPECT_EQ(a.motion.force, b.motion.force) << step;
    EXPECT_EQ(a.layers.c_his, b.layers.c_his) << step;
    EXPECT_EQ(a.cracked.gathered.size(), b.cracked.gathered.size()) << step;
  }
  EXPECT_GT(a.cracked.gathered.size(), 0u);
}
