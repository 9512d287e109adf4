// One substep of shells and bodies together.
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "shell/run/substep.h"
#include "shell/solver/parting/handoff.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

RigidBody large_ball(const Vec3& at, const Vec3& velocity) {
  RigidBody b;
  b.id = 1, b.name = "ball", b.mass = 0.1, b.principal_inertia = Vec3::Constant(1e-5), b.shape = SphereShape{0.02};
  b.motion.position = at, b.motion.velocity = velocity;
  return b;
}

}  // namespace

// Leapfrog: velocities stand half a step behind positions.
TEST(Substep, OfAShellAtRestIsFreeFall) {
  const Vec3 gravity(1, 0, -9.81), v(2, -1, 3);
  RunSetup setup = setup_of({{brittle_sheet(6), v}});
  setup.gravity = gravity;
  setup.bodies = {large_ball(Vec3(0, 0, 5), v)};
  Rig rig(std::move(setup));
  const Vec3 start = rig.state().position(rig.model().tables.slot(9));
  constexpr int kSteps = 50;
  constexpr double kStep = 1e-7;
  for (int k = 0; k < kSteps; ++k) rig.step(kStep);
  const Vec3 moved = kSteps * kStep * v + 0.5 * kSteps * (kSteps + 1) * kStep * kStep * gravity;
  EXPECT_LT((rig.state().position(rig.model().tables.slot(9)) - start - moved).norm(), 1e-15);  // of 0.2 m
  EXPECT_LT((rig.state().velocity(rig.model().tables.slot(9)) - v - kSteps * kStep * gravity).norm(), 1e-10);
  EXPECT_LT((rig.body().body.motion.position - Vec3(0, 0, 5) - moved).norm(), 5e-14);  // of 5 m
  EXPECT_NEAR(rig.state().motion.time, kSteps * kStep, 1e-18);
}

// The first substep of a run starts at the velocities of time zero and kicks by half: exact at any step.
TEST(Substep, TheFirstOfARunMakesFreeFallExact) {
  const Vec3 gravity(1, 0, -9.81), v(2, -1, 3);
  RunSetup setup = setup_of({{brittle_sheet(6), v}});
  setup.gravity = gravity;
  setup.bodies = {large_ball(Vec3(0, 0, 5), v)};
  Rig rig(std::move(setup));
  const int slot = rig.model().tables.slot(9);
  const Vec3 start = rig.state().position(slot);
  const double energy = rig.simulation().total_energy(0.0);
  constexpr int kSteps = 7;
  constexpr double kStep = 4e-7, kTime = kSteps * kStep;
  rig.simulation().take_substeps(kSteps, kStep, 0.0, Clock{}, [] {});
  const Vec3 fallen = kTime * v + 0.5 * kTime * kTime * gravity;
  EXPECT_LT((rig.state().position(slot) - start - fallen).norm(), 1e-15);  // of 0.2 m; half a kick is 6e-12
  EXPECT_LT((rig.body().body.motion.position - Vec3(0, 0, 5) - fallen).norm(), 5e-15);
  EXPECT_LT((rig.body().body.motion.velocity - v - kTime * gravity).norm(), 1e-14);
  // leapfrog's energy is m g^2 dt^2 / 8 off, 1e-13 of the whole
  EXPECT_NEAR(rig.simulation().total_energy(kStep) / energy, 1.0, 3e-13);
}

TEST(Substep, KeepsTheMomentumOfShellAndBodyAndFillsBothPages) {
  RunSetup setup = setup_of({{brittle_sheet(12)}});
  setup.bodies = {large_ball(Vec3(0.01, 0.02, 0.023), Vec3(1, 0, -4))};
  setup.laws = {{0, 0, 0.4, 0.0}};
  Rig rig(std::move(setup));
  const RigidBody before = rig.body().body;
  const Totals shell = totals(rig.model(), rig.state());
  for (int k = 0; k < 2000; ++k) rig.step(4e-7);
  const Proxy& p = rig.body();
  const RigidBody& b = p.body;
  const Totals now = totals(rig.model(), rig.state());
  EXPECT_GT(b.motion.velocity.z(), before.motion.velocity.z() + 0.5);  // they met
  EXPECT_GT(rig.state().book.contact, 0.0);
  const Vec3 gained = b.mass * (b.motion.velocity - before.motion.velocity);
  EXPECT_LT((now.momentum - shell.momentum + gained).norm(), 1e-12 * p.impulse_sum);
  EXPECT_LT((p.linear_impulse + p.shell_linear).norm(), 1e-13 * p.impulse_sum);
  EXPECT_LT((p.angular_impulse + p.shell_angular).norm(), 1e-12 * p.moment_sum);
  EXPECT_LT((p.linear_impulse - gained).norm(), 1e-12 * p.impulse_sum);
}

TEST(Substep, IsTheSameWhereShellsAreSolvedAtOnce) {
  std::vector<std::vector<double>> ends;
  for (const int threads : {1, 2}) {
    Rig rig(setup_of({{brittle_sheet(40)}, {brittle_sheet(36)}}), threads);
    EXPECT_EQ(rig.simulation().model.shells_at_once, threads);
    for (const std::size_t k : {0u, 1u}) disturb(rig.state(k), rig.model(k), 1e-5);
    rig.run(20, 1e-7);
    ends.push_back(rig.state(0).motion.x);
    ends.push_back(rig.state(1).motion.v);
  }
  EXPECT_EQ(ends[0], ends[2]);
  EXPECT_EQ(ends[1], ends[3]);
}

TEST(SideBySide, ThrowsOnWhatOneShellThrows) {
  Rig rig(setup_of({{brittle_sheet(40)}, {brittle_sheet(40)}}), 2);
  Simulation& sim = rig.simulation();
  std::vector<int> done(2, 0);
  const auto one = [&](std::size_t k) {
    done[k] = 1;
    if (k == 0) throw std::runtime_error("the first");
  };
  EXPECT_THROW(side_by_side(sim.state, sim.scratch, sim.model.shells_at_once, one), std::runtime_error);
  EXPECT_EQ(done, (std::vector<int>{1, 1}));  // the other one has ended too
}
