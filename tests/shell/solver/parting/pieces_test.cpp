#include <vector>

#include <gtest/gtest.h>

#include "shell/solver/cracking/polyline.h"
#include "shell/solver/parting/pieces.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(Pieces, AreHeldAlongOneAxisTooAndNotByAClampedSlope) {
  ShellMaterial g = glass();
  const auto held = [&](const Support& support, double cut) {
    const ShellModel m =
        make_shell("p", plate(0.2, 0.2, 10, 10, Vec3::Zero(), Quat::Identity()), 0.004, g, 2, 2, {support});
    ShellState s = make_state(m, Vec3::Zero(), 1);
    insert_polyline(m, s, {{cut, 0.0}, {cut, 0.2}}, 0.0);
    std::vector<Piece> pieces;
    partition(m, s, pieces);
    int count = 0;
    for (const Piece& p : pieces) count += p.held;
    return pieces.size() == 2 ? count : -1;
  };
  Support clamp, along;
  clamp.edges = along.edges = kUMin;
  along.clamped = false, along.axes = {false, false, true};
  EXPECT_EQ(held(clamp, 0.1), 1);
  EXPECT_EQ(held(along, 0.1), 1);
  EXPECT_EQ(held(clamp, 0.005), 1);  // between the rows of the clamped edge, at 0 and 0.01: the strip, not the rest
}
