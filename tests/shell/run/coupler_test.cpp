// What the engine is asked for, window by window.
#include <gtest/gtest.h>

#include "tests/shell/free_run.h"

using namespace sunder;
using namespace sunder::shell;

TEST(Coupler, LoadsTheBodiesOfTheScene) {
  FreeRun run;
  run.execute();
  ASSERT_EQ(run.asked.world.bodies.size(), 1u);
  const RigidBody& ball = run.asked.world.bodies[0];
  EXPECT_EQ(ball.name, "ball");
  EXPECT_NEAR(ball.mass, 2500.0 * 4.0 / 3.0 * M_PI * 8e-6, 1e-15);
  EXPECT_EQ(ball.motion.position, Vec3(1, 0, 0.5));
  EXPECT_EQ(run.asked.world.tick, 0);
  EXPECT_DOUBLE_EQ(run.asked.world.thickness, 0.004);
}

// A body that nothing touches falls: gravity is spread over the substeps, each of which moves with the new velocity.
TEST(Coupler, PredictsAFreeFall) {
  FreeRun run;
  run.execute();
  const double window = 1e-4, substep = 1e-3 / run.summary()["time"]["substeps"].get<double>();
  std::int64_t tick = 0;
  for (std::size_t k = 0; k < run.asked.tasks.size(); ++k) {
    const link::WindowTask& task = run.asked.tasks[k];
    EXPECT_EQ(task.tick, tick);
    EXPECT_DOUBLE_EQ(task.window_s, window);
    EXPECT_FALSE(task.again);
    EXPECT_TRUE(task.births.empty());
    EXPECT_TRUE(task.solved.empty());
    tick += task.ticks;
    ASSERT_EQ(task.predicted.size(), 1u);
    const double time = static_cast<double>(k + 1) * window;
    EXPECT_LT((task.predicted[0].motion.velocity - Vec3(3, 0, -10 * time)).norm(), 1e-14);
    const Vec3 exact(1 + 3 * time, 0, 0.5 - 5 * time * time);
    EXPECT_LT((task.predicted[0].motion.position - exact).norm(),
              5.05 * time * substep);                                      // half a substep of fall, and round-off
    EXPECT_NEAR(task.predicted[0].motion.position.x(), exact.x(), 1e-12);  // round-off of some hundred substeps
  }
}

TEST(Coupler, NothingIsExchangedWhereNothingTouches) {
  FreeRun run;
  run.execute();
  const auto summary = run.summary();
  EXPECT_LT(summary["ledger"]["linear_max"].get<double>(), 1e-15);  // round-off
  EXPECT_LT(summary["ledger"]["angular_max"].get<double>(), 1e-15);
  EXPECT_EQ(summary["coupling"]["scheme"], "PROXY");
  EXPECT_EQ(summary["coupling"]["exported_bodies"], 0);
  EXPECT_EQ(summary["coupling"]["passes_a_window"], 1.0);
}
