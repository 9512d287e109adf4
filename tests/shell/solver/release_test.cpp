// Release of supports.
#include "shell/solver/release.h"

#include <gtest/gtest.h>

#include "shell/solver/parting/handoff.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kStep = 5e-7, kUntil = 1e-4;  // [s]

Support edge(int edges, double until = std::numeric_limits<double>::infinity()) {
  Support s;
  s.edges = edges, s.until = until;
  return s;
}

int held(const ShellState& s, const ShellModel& m) {
  int count = 0;
  for (int i = 0; i < m.control_points(); ++i) count += s.motion.inverse_mass[m.tables.slot(i)] == 0.0;
  return count;
}

}  // namespace

TEST(Release, LeavesWhatOtherSupportsHold) {
  Rig rig(setup_of({{strip({edge(kUMin, kUntil), edge(kVMin)}, {})}}));
  const int columns = rig.model(0).patch.columns(), rows = rig.model(0).patch.rows();
  EXPECT_EQ(held(rig.state(0), rig.model(0)), 2 * columns + 2 * (rows - 2));
  EXPECT_EQ(rig.model(0).constraints.parts.size(), 2u);
  EXPECT_FALSE(rig.simulation().release_supports(0.9 * kUntil, 0.0, kStep));
  EXPECT_TRUE(rig.simulation().release_supports(kUntil, 0.0, kStep));
  EXPECT_FALSE(rig.simulation().release_supports(kUntil, 0.0, kStep));
  EXPECT_EQ(held(rig.state(0), rig.model(0)), 2 * columns);
  ASSERT_EQ(rig.model(0).constraints.parts.size(), 2u);  // columns of probes.csv stay
  EXPECT_TRUE(rig.model(0).constraints.parts[0].slots[2].empty());
  EXPECT_EQ(rig.model(0).constraints.parts[1].slots[2].size(), 2u * columns);
  EXPECT_EQ(rig.model(0).clamped, kVMin);
}

// Leapfrog conserves energy to round-off, and the release changes nothing of it: the strip is bent by its velocity,
// is released, and flies on.
TEST(Release, ChangesNeitherEnergyNorMomentum) {
  for (const bool driven : {false, true}) {
    SCOPED_TRACE(driven);
    Support clamp = edge(kUMin, kUntil);
    if (driven) clamp.motion = {{0.0, Vec3::Zero()}, {1.0, Vec3(0, 0, 20.0)}};
    RunSetup setup = setup_of({{strip({clamp}, {}), Vec3(0, 0, 5)}});
    setup.gravity = Vec3(3, 0, -9.81);
    Rig rig(std::move(setup));
    rig.run(200, kStep);
    const auto energy = [&] {
      const double sum = rig.simulation().total_energy(kStep);
      return sum - rig.state(0).book.external;
    };
    const double before = energy();
    const Totals then = totals(rig.model(0), rig.state(0));
    ASSERT_TRUE(rig.simulation().release_supports(kUntil, 0.0, kStep));
    EXPECT_NEAR(energy(), before, 1e-12 * before);
    const Totals now = totals(rig.model(0), rig.state(0));
    EXPECT_NEAR((now.momentum - then.momentum).norm(), 0.0, 1e-12 * then.momentum_scale);
    rig.run(400, kStep);
    EXPECT_NEAR(energy(), before, 1e-6 * before);  // of leapfrog, at large displacements
    const Totals later = totals(rig.model(0), rig.state(0));
    const Vec3 fallen = 400 * kStep * later.mass * Vec3(3, 0, -9.81);
    EXPECT_NEAR((later.momentum - now.momentum - fallen).norm(), 0.0, 1e-11 * later.momentum_scale);
    EXPECT_GT(rig.state(0).velocity(rig.model(0).tables.slot(0)).norm(), 0.1);  // the end that was held moves
  }
}

// A checkpoint has the number of releases; the model of a new run takes the same supports.
TEST(Release, IsRestoredFromTheState) {
  Rig first(setup_of({{strip({edge(kUMin, kUntil)}, {})}})), again(setup_of({{strip({edge(kUMin, kUntil)}, {})}}));
  ASSERT_TRUE(first.simulation().release_supports(kUntil, 0.0, kStep));
  again.state(0) = first.state(0);
  again.simulation().restore_supports();
  EXPECT_EQ(again.model(0).held, first.model(0).held);
  EXPECT_EQ(again.model(0).clamped, 0);
  EXPECT_TRUE(again.model(0).constraints.anchors.empty());
}
