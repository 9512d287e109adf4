// Area of a shell, parted by what its Gauss points bear.
#include <gtest/gtest.h>

#include "shell/io/probes.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

// A cut pane, stretched by a fifth in one direction, of which some points bear nothing and some have left.
TEST(SurfaceArea, IsPartedByWhatPointsBear) {
  constexpr double kStretch = 1.2, kArea = 0.2 * 0.2;  // [m^2]
  const ShellModel m = brittle_sheet(8);
  ShellState s = make_state(m, Vec3::Zero(), 0);
  EXPECT_NEAR(surface_area(m, s).rest, kArea, 1e-15);
  EXPECT_TRUE(surface_area(m, s).whole());
  insert_polyline(m, s, {{0.03, 0.09}, {0.17, 0.11}}, 0.0);
  for (int i = 0; i < m.tables.component_stride; ++i) s.motion.x[i] *= kStretch;
  const SurfaceArea cut = surface_area(m, s);
  const double before = cut.torn;  // a few points beside a crack may have too few neighbours
  EXPECT_NEAR(cut.rest + cut.torn, kArea, 1e-14);

  double torn = 0.0, gone = 0.0;
  int torn_row = -1, torn_lane = -1;
  for (GatheredPoint& g : s.cracked.gathered) {
    if (g.in_rows || g.kind == PointKind::kDead || (torn > 0.0 && gone > 0.0)) continue;
    (torn > 0.0 ? gone : torn) += g.area;
    if (gone == 0.0)
      torn_row = g.block / (m.tables.gauss * m.tables.gauss), torn_lane = g.lane;
    else
      g.handed_off = true;
    g.kind = PointKind::kDead, g.functions.clear();
  }
  const SurfaceArea all = surface_area(m, s);
  EXPECT_GT(torn, 0.0);
  EXPECT_GT(gone, 0.0);
  EXPECT_NEAR(all.torn - before, torn, 1e-15);
  EXPECT_NEAR(all.gone, gone, 1e-15);
  EXPECT_NEAR(all.rest + all.torn + all.gone, kArea, 1e-14);
  EXPECT_NEAR(all.now, kStretch * all.rest, 1e-12);  // a homogeneous stretch is exact beside cracks too
  EXPECT_FALSE(all.whole());
  EXPECT_GT(surface_area(m, s, torn_row, torn_lane).torn, 0.0);

  // An element whose control points have left is gone, and no element is counted twice.
  SurfaceArea sum;
  for (int row = 0; row < m.tables.spans_v; ++row)
    for (int lane = 0; lane < m.tables.spans_u; ++lane) sum += surface_area(m, s, row, lane);
  EXPECT_EQ(sum.now, all.now);
  const SurfaceArea corner = surface_area(m, s, 0, 0);
  EXPECT_TRUE(corner.whole());
  std::fill(s.motion.detached.begin(), s.motion.detached.end(), 1);
  EXPECT_NEAR(surface_area(m, s, 0, 0).gone, corner.rest, 1e-16);
  EXPECT_EQ(surface_area(m, s).now, 0.0);
}
