// Which parts of shells may meet before the next look.
#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "shell/solver/contact/near_tiles.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

ShellModel tiled_sheet(const Vec3& at) {
  return make_shell("sheet", plate(0.4, 0.4, 16, 16, at, Quat::Identity()), 0.01, glass(), 2, 2, {});
}

/// Tiles of two sheets, the upper one `apart` above the other and falling at `speed`, that are candidates.
int candidates(double apart, double speed, double aside = 0.0) {
  const ShellModel low = tiled_sheet(Vec3::Zero()), high = tiled_sheet(Vec3(aside, 0, apart));
  ShellState a = make_state(low, Vec3::Zero(), 0), b = make_state(high, Vec3(0, 0, -speed), 0);
  NearTiles near({&low, &high}, {}, components(2, {}), 0.002, 0.05);
  near.refresh({{&low, &a}, {&high, &b}}, 1e-5);
  EXPECT_EQ(near.tiles().size(), 32u);  // 4 x 4 elements each
  return static_cast<int>(
      std::count_if(near.tiles().begin(), near.tiles().end(), [](const Tile& t) { return t.candidate; }));
}

}  // namespace

TEST(Components, AreWhatSeamsJoinDirectlyOrThroughOthers) {
  std::vector<Seam> seams(2);
  seams[0].first = 4, seams[0].second = 1, seams[1].first = 2, seams[1].second = 4;
  const auto together = components(5, seams);
  for (std::size_t i = 0; i < 5; ++i)
    for (std::size_t k = 0; k < 5; ++k) {
      const auto joined = [](std::size_t n) { return n == 1 || n == 2 || n == 4; };
      EXPECT_EQ(together[i][k] != 0, i == k || (joined(i) && joined(k))) << i << k;
    }
}

// They touch at 10 mm; 2 mm of margin, and twice the way of 16 substeps.
TEST(NearTiles, AreThoseThatMayTouchBeforeTheNextLook) {
  EXPECT_EQ(candidates(0.0119, 0.0), 32);
  EXPECT_EQ(candidates(0.0121, 0.0), 0);
  EXPECT_EQ(candidates(0.0121, 1.0), 32);  // 0.32 mm of way
  EXPECT_EQ(candidates(0.0125, 1.0), 0);
  EXPECT_EQ(candidates(0.0119, 0.0, 1.0), 0);         // beside one another
  const int overlap = candidates(0.0119, 0.0, 0.29);  // by 0.11 m: one column of tiles of 0.1 m, and a bit of the next
  EXPECT_GE(overlap, 8);
  EXPECT_LE(overlap, 16);
}

TEST(NearTiles, OfOneSurfaceAreNoneUntilItFolds) {
  const ShellModel m =
      make_shell("sheet", plate(1.0, 0.4, 40, 16, Vec3::Zero(), Quat::Identity()), 0.01, glass(), 2, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  NearTiles near({&m}, {}, components(1, {}), 0.002, 0.05);
  const auto any = [&] {
    near.refresh({{&m, &s}}, 1e-5);
    return std::any_of(near.tiles().begin(), near.tiles().end(), [](const Tile& t) { return t.candidate; });
  };
  EXPECT_FALSE(any());
  const std::vector<double> flat = s.motion.x;
  for (int i = 0; i < m.control_points(); ++i) {  // both halves up, 4 mm apart
    const int slot = m.tables.slot(i);
    const double x = flat[slot];
    s.motion.x[slot] = x < 0.0 ? -0.002 : 0.002, s.motion.x[2 * m.tables.component_stride + slot] = std::abs(x);
  }
  EXPECT_TRUE(any());
  s.motion.detached.assign(s.motion.detached.size(), 1);  // what is handed off is no candidate
  EXPECT_FALSE(any());
}

TEST(NearTiles, LeaveOutShellsThatAreNotAsked) {
  const ShellModel low = tiled_sheet(Vec3::Zero()), high = tiled_sheet(Vec3(0, 0, 0.011));
  ShellState a = make_state(low, Vec3::Zero(), 0), b = make_state(high, Vec3::Zero(), 0);
  NearTiles near({&low, &high}, {1, 0}, components(2, {}), 0.002, 0.05);
  near.refresh({{&low, &a}, {&high, &b}}, 1e-5);
  EXPECT_EQ(near.tiles().size(), 16u);
  for (const Tile& t : near.tiles()) EXPECT_FALSE(t.candidate);
}
