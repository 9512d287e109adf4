// The energy books of a run.
#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/run/books.h"
#include "shell/solver/finite.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"

using namespace sunder;
using namespace sunder::shell;

TEST(EnergyBook, LosesWhatEachEntryTakesAndGainsWorkAndInjection) {
  EnergyBook b;
  b.fracture = 1, b.injected = 2, b.contact = 4, b.handoff = 8, b.external = 16, b.healing = 32, b.plastic = 64;
  b.damping = 128, b.transfer = 256, b.frozen = 512, b.face_friction = 1024, b.face_crushing = 2048;
  EXPECT_EQ(b.lost(), 1024 + 2048 + 1 + 4 + 8 + 32 + 64 + 128 + 256 + 512 - 2 - 16);
  EnergyBook twice = b;
  twice += b;
  EXPECT_EQ(twice.lost(), 2.0 * b.lost());
  EXPECT_EQ(twice.handoff, 16.0);
}

TEST(Books, SumThoseOfShellsThatAreFrozenAndThatAreNot) {
  Rig rig(setup_of({{brittle_sheet(4)}, {brittle_sheet(4)}}));
  rig.state(0).book.contact = 2.0, rig.state(1).book.contact = 3.0;
  Books books;
  books.frozen.contact = 10.0;
  EXPECT_EQ(books.sum(rig.simulation()).contact, 15.0);
  rig.now().shells[1].state.reset();
  EXPECT_EQ(books.sum(rig.simulation()).contact, 12.0);
}

TEST(Books, ResidualIsWhatIsMissingOverTheLargestEnergyThereWas) {
  Rig rig(setup_of({{brittle_sheet(4)}}));
  Books books;
  rig.now().kinetic = 3.0, rig.now().elastic = 1.0;
  books.open(rig.simulation(), 5.0);
  EXPECT_EQ(books.scale, 4.0);
  rig.now().kinetic = 7.0;
  books.close(rig.simulation(), 5.4, 1.0);
  EXPECT_EQ(books.scale, 8.0);
  EXPECT_NEAR(books.residual, 0.4 / 8.0, 1e-15);
  rig.now().kinetic = 1.0;
  books.close(rig.simulation(), 4.6, 2.0);
  EXPECT_NEAR(books.residual, -0.4 / 8.0, 1e-15);  // it was more once
}

// The engine holds a box on a floor, and the books miss the round-off of its weight's potential.
TEST(Books, MissNothingOfABoxAtRest) {
  RunSetup setup;
  setup.gravity = Vec3(0, 0, -9.81), setup.window = 1e-3;
  RigidBody box;
  box.id = 1, box.name = "box", box.mass = 500.0, box.principal_inertia = Vec3::Constant(1.0);
  box.shape = BoxShape{Vec3::Constant(0.1)}, box.motion.position = {0, 0, 0.1};
  setup.bodies = {box};
  Rig rig(std::move(setup));
  const double energy = rig.simulation().total_energy(0.0);
  EXPECT_NEAR(energy, 500.0 * 9.81 * 0.1, 1e-10);
  Books books;
  books.open(rig.simulation(), energy);
  EXPECT_NEAR(books.scale, 0.5 * 500.0 * 9.81e-3 * 9.81e-3, 1e-15);
  for (const double sign : {1.0, -1.0, 1.0})
    books.close(rig.simulation(), energy * (1.0 + sign * std::numeric_limits<double>::epsilon()), 1e-3);
  EXPECT_LT(std::abs(books.residual), 1e-9);
  EXPECT_EQ(books.deforming, 0.0);
  EXPECT_TRUE(warnings(books, rig.simulation(), 0.0, 0.0).empty());
  books.close(rig.simulation(), energy + books.scale, 2e-3);  // the energy of one window is no round-off
  EXPECT_EQ(warnings(books, rig.simulation(), 0.0, 0.0).size(), 1u);
}

TEST(Books, KeepTheLargestGapAndTheWindowInWhichItGrewMost) {
  Rig rig(setup_of({{brittle_sheet(4)}}));
  Books books;
  books.open(rig.simulation(), 1.0);
  rig.now().kinetic = 2.0, rig.now().elastic = 0.5;
  rig.state().book.plastic = 0.25, rig.state().book.contact = -0.5;
  double time = 0.0;
  for (const double energy : {1.1, 0.7, 0.6, 1.0}) books.close(rig.simulation(), energy, time += 0.25);
  EXPECT_EQ(books.gap, 0.0);
  EXPECT_NEAR(books.largest_gap, -0.4, 1e-15);
  EXPECT_NEAR(books.window_gap, -0.4, 1e-15);
  EXPECT_EQ(books.window_gap_time, 0.5);  // the fourth window changed as much
  EXPECT_EQ(books.deforming, 3.25);
  books.close(rig.simulation(), std::numeric_limits<double>::quiet_NaN(), 2.0);
  EXPECT_TRUE(std::isnan(books.window_gap));
}

TEST(Books, KeepTheMostThatContactHasGivenBack) {
  Rig rig(setup_of({{brittle_sheet(4)}}));
  Books books;
  books.open(rig.simulation(), 0.0);
  for (const double taken : {1.0, 0.7, 3.0, 2.5, 2.9})
    rig.state().book.contact = taken, books.close(rig.simulation(), 0, 0);
  EXPECT_EQ(books.contact_taken, 3.0);
  EXPECT_NEAR(books.contact_returned, 0.5, 1e-15);
}

// An engine that gives a body speed is told, with shells in the scene and without.
TEST(Books, KeepTheMostThatTheEngineHasMade) {
  RunSetup setup;
  setup.end_time = 1.0;
  Rig rig(std::move(setup));
  rig.now().kinetic = 4.0;
  Books books;
  books.open(rig.simulation(), 4.0);
  for (const double taken : {0.5, 0.47, 0.9, 0.88})
    rig.now().engine_loss = taken, books.close(rig.simulation(), 4.0, 0.0);
  EXPECT_NEAR(books.engine_returned, 0.03, 1e-15);
  const auto told = [&] {
    const std::vector<std::string> all = warnings(books, rig.simulation(), 0.0, 0.0);
    return std::count_if(all.begin(), all.end(), [](const std::string& w) {
      return w.find("the rigid engine has made 10.0 % of the energy there was") != std::string::npos;
    });
  };
  EXPECT_EQ(told(), 0);
  rig.now().engine_loss = 0.5, books.close(rig.simulation(), 4.0, 0.0);
  EXPECT_EQ(told(), 1);
}

TEST(Books, StopARunWhoseEnergyHasGoneBeyondWhatTheSceneHas) {
  Rig rig(setup_of({{brittle_sheet(4)}}));
  rig.now().kinetic = 1.0;
  Books books;
  books.open(rig.simulation(), 1.0);
  books.check_stable(rig.simulation(), 3.0, 5);
  ShellState& state = *rig.now().shells[0].state;
  const RowTables& tables = rig.setup().shells[0].model.tables;
  state.add_velocity(tables.slot(0), Vec3(0, 0, 7));
  state.add_velocity(tables.slot(3), Vec3(0, 0, 9));
  state.motion.detached[tables.slot(3)] = true;  // it has left with a piece
  // an element at a strain of 1e-3 stores less than 0.4 J
  for (const double energy : {1e4, -1e4, std::numeric_limits<double>::quiet_NaN()}) {
    try {
      books.check_stable(rig.simulation(), energy, 5);
      ADD_FAILURE() << energy;
    } catch (const Error& e) {
      EXPECT_EQ(e.kind, "unstable");
      EXPECT_EQ(e.window, 5);
      const std::string said = e.what();
      EXPECT_NE(said.find("shell 'p' is unstable, fastest at (u, v) = (0, 0) with 7 m/s; lower"), std::string::npos)
          << said;
    }
  }
}

TEST(Books, StopARunWithABodyThatIsNowhere) {
  RigidBody ball;
  ball.name = "ball", ball.shape = SphereShape{0.1};
  std::vector<Proxy> bodies{Proxy(ball)};
  check_finite(bodies, 5, {0.8, 0.0});
  bodies[0].body.motion.velocity.y() = std::numeric_limits<double>::infinity();
  try {
    check_finite(bodies, 5, {0.8, 0.0});
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind, "unstable");
    EXPECT_EQ(e.body, "ball");
    EXPECT_EQ(e.window, 5);
    EXPECT_NE(std::string(e.what()).find("; lower time_step_safety"), std::string::npos) << e.what();
  }
}
