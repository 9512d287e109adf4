// A rational patch that is cut into pieces: they fly, and leave, with the momentum and the spin that they had.
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "shell/geometry/builders.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/parting/handoff.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kRoundOff = 1e-12;  // of the sums' own magnitudes

void expect_the_same(const Totals& now, const Totals& before, const char* when) {
  EXPECT_NEAR(now.mass, before.mass, kRoundOff * before.mass) << when;
  EXPECT_LT((now.momentum - before.momentum).norm(), kRoundOff * before.momentum_scale) << when;
  EXPECT_LT((now.angular - before.angular).norm(), kRoundOff * before.angular_scale) << when;
}

}  // namespace

TEST(CutCylinder, FliesAndLeavesWithItsMomentumAndSpin) {
  Rig rig(
      setup_of({{make_shell("c", cylinder(0.2, 0.2, 1.0, 24, 24), 0.004, glass(), 2, 2, {}), Vec3(0.3, -0.2, 0.5)}}));
  const ShellModel& m = rig.model();
  ShellState& s = rig.state();
  ASSERT_TRUE(m.patch.rational());
  for (const auto& cut : std::vector<std::vector<Vec2>>{{{0.0, 0.071}, {0.2, 0.093}}, {{0.083, 0.0}, {0.119, 0.2}}})
    insert_polyline(m, s, cut, 0.0);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int i = 0; i < m.control_points(); ++i) {  // turns, and swings
    const int slot = m.tables.slot(i);
    s.add_velocity(
        slot, Vec3(5, -3, 8).cross(s.position(slot)) + 0.05 * Vec3(uniform(random), uniform(random), uniform(random)));
  }
  const Totals before = totals(m, s);
  const double dt = 0.8 * stable_step(m, s, 200, 1, true);
  rig.run(400, dt);
  compute_forces(m, s, false, 1.0, 1);
  Totals now = totals(m, s);
  expect_the_same(now, before, "after the flight");
  std::vector<Piece> pieces;
  partition(m, s, pieces);
  ASSERT_EQ(pieces.size(), 4u);
  Totals bodies;
  for (int left = 4; left > 0; --left) {
    const Triangulation t = partition(m, s, pieces);
    const auto piece = std::find_if(pieces.begin(), pieces.end(), [](const Piece& p) { return !p.handed_off; });
    ASSERT_NE(piece, pieces.end());
    const RigidBody b = hand_off(m, s, t, *piece, left, dt).body;
    bodies.mass += b.mass, bodies.momentum += b.mass * b.motion.velocity;
    bodies.angular += b.motion.angular_momentum + b.motion.position.cross(b.mass * b.motion.velocity);
    Totals all = totals(m, s);
    all += bodies;
    expect_the_same(all, now, "with the pieces that were handed off");
  }
}
