// Rebounds within a window: where they are sound, and that bodies lose nothing of it.
#include "rigid/engine/rebound.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "tests/rigid/every_engine.h"

namespace sunder::rigid {
namespace {

using namespace testing;  // NOLINT: the helpers of this folder

constexpr double kH = 1e-3;  // [s]

Strike strike(std::uint32_t first, std::uint32_t second, double gap = 0.5e-3) {
  return {first, second, gap, 2.0, -9.81, 1.0, true};
}

std::vector<std::optional<Rebound>> of(const std::vector<Strike>& strikes, const std::set<std::uint32_t>& joined = {}) {
  return rebounds(
      strikes, kH, [](std::uint32_t id) { return id == 1; }, [&](std::uint32_t id) { return joined.count(id) > 0; });
}

TEST(Rebound, KeepsTheEnergyOfAFallAtAnyTouch) {
  for (const double gap : {0.0, 1e-6, 0.5e-3, 1.9e-3}) {
    const Strike s = strike(2, 1, gap);
    const auto r = rebound(s, kH);
    ASSERT_TRUE(r) << gap;
    const double start = s.approach + 0.5 * s.pull * kH, rest = kH - r->touch;
    EXPECT_NEAR(start * r->touch - 0.5 * s.pull * r->touch * r->touch, gap, 1e-15);
    const double place = r->speed * rest - 0.5 * s.pull * rest * rest;  // at the end
    EXPECT_NEAR(0.5 * r->speed * r->speed - s.pull * place, 0.5 * start * start - s.pull * gap, 1e-12) << gap;
  }
}

TEST(Rebound, IsNoneWhereItIsUnsound) {
  EXPECT_TRUE(rebound(strike(2, 1), kH));
  Strike s = strike(2, 1);
  s.restitution = 0.0;
  EXPECT_FALSE(rebound(s, kH));
  s = strike(2, 1), s.approach = -0.1;
  EXPECT_FALSE(rebound(s, kH));
  s = strike(2, 1), s.pull = 500.0;  // a shell has pushed the body within the window
  EXPECT_FALSE(rebound(s, kH));
  EXPECT_FALSE(rebound(strike(2, 1, 2.1e-3), kH));  // they do not meet
  s = strike(2, 1, 0.0), s.restitution = 1e-3;      // gravity brings it back
  EXPECT_FALSE(rebound(s, kH));
}

TEST(Rebounds, AreOfPairsThatMeetNothingElse) {
  EXPECT_TRUE(of({strike(2, 1)})[0]);
  const auto several = of({strike(2, 1), strike(3, 1), strike(4, 5)});  // 1 is static
  EXPECT_TRUE(several[0] && several[1] && several[2]);
  const auto chain = of({strike(2, 1), strike(2, 3), strike(4, 1)});
  EXPECT_FALSE(chain[0] || chain[1]);
  EXPECT_TRUE(chain[2]);
  Strike beside = strike(2, 3);
  beside.acted = false;
  EXPECT_FALSE(of({strike(2, 1), beside})[0]);
  EXPECT_FALSE(of({strike(2, 1)}, {2})[0]);
}

TEST(Rebounds, OfAllContactsOfAPairAreOne) {
  const auto both = of({strike(2, 1, 0.5e-3), strike(2, 1, 0.52e-3)});
  ASSERT_TRUE(both[0] && both[1]);
  EXPECT_EQ(both[0]->touch, both[1]->touch);
  EXPECT_NEAR(both[0]->touch, 0.26e-3, 1e-6);
  const auto tilted = of({strike(2, 1, 0.5e-3), strike(2, 1, 1.0e-3)});
  EXPECT_FALSE(tilted[0] || tilted[1]);
  Strike slow = strike(2, 1, 0.51e-3);
  slow.restitution = 0.0;
  EXPECT_FALSE(of({strike(2, 1), slow})[0]);
}

INSTANTIATE_TEST_SUITE_P(Of, EveryEngine, ::testing::Values(kBullet, kOde), name_of);

// 20 bounces of 0.2 s each in 4000 windows of 1 ms, no whole number of which is a bounce. The ball's flight is exact,
// as a run's is. A rebound at the window's end loses up to 2 mm of place, and a share of 1e-2 of the energy.
TEST_P(EveryEngine, ABallBouncesAtTheRightTimesAndKeepsItsEnergy) {
  constexpr double kDrop = 0.05 + 1.3e-4, kRadius = 0.05;
  const auto engine = make();
  engine->set_contact_laws({{0, 0, 0.3, 1.0}});
  RigidBody ball = sphere(2, kRadius, 0.3);
  ball.motion.position.z() = kRadius + kDrop;
  engine->add(half_space(1));
  engine->add(ball);
  const double period = 2.0 * std::sqrt(2.0 * kDrop / kGravity);
  double most = 0.0, lost = 0.0;
  for (int n = 1; n <= 4000; ++n) {
    ball.motion.position.z() += kH * ball.motion.velocity.z() - 0.5 * kGravity * kH * kH;
    ball.motion.velocity.z() -= kGravity * kH;
    engine->advance(kH, {{2, ball.motion}}, {});
    ball.motion = engine->states()[0].motion;
    const double phase = std::fmod(n * kH + 0.5 * period, period) - 0.5 * period;
    const double height = kDrop - 0.5 * kGravity * phase * phase;
    most = std::max(most, std::abs(ball.motion.position.z() - kRadius - height));
    const double energy = 0.5 * std::pow(ball.motion.velocity.z(), 2) + kGravity * (ball.motion.position.z() - kRadius);
    lost = std::max(lost, std::abs(energy / (kGravity * kDrop) - 1.0));
  }
  // Residuals of the solver, relative, in 20 bounces. Each changes the period of all that follow: a ball of 1 m/s is off
  // by up to 20 * 20 / 2 of them times 0.2 m. The rest is the margin.
  EXPECT_LT(most, 1e3 * GetParam().solved);
  EXPECT_LT(lost, 1e3 * GetParam().solved);
}

}  // namespace
}  // namespace sunder::rigid
