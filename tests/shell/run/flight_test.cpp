// Windows without a shell: free fall, and how long they may be.
#include <vector>

#include <gtest/gtest.h>

#include "shell/run/flight.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

Proxy ball(const Vec3& at, const Vec3& velocity) {
  RigidBody b;
  b.id = 1, b.name = "ball", b.mass = 0.1, b.principal_inertia = Vec3::Constant(1e-5), b.shape = SphereShape{0.01};
  b.motion.position = at, b.motion.velocity = velocity;
  return Proxy(b);
}

Proxy of_static(Proxy p) {
  p.body.is_static = true;
  return p;
}

/// A shell of 4 mm, so that bodies may approach one another by 5 mm; windows of 1 to 20 ticks of 1 ms.
RunSetup settling() {
  RunSetup s = setup_of({{brittle_sheet(4)}});
  s.tick = 1e-3, s.settle_window = 0.02;
  return s;
}

}  // namespace

TEST(Flight, IsAParabola) {
  const Vec3 gravity(0.5, 0, -9.81), x(1, 2, 3), v(-1, 0.3, 2);
  for (const double window : {1e-3, 0.1}) {
    std::vector<Proxy> bodies{ball(x, v), of_static(ball(x, v)), ball(x, v)};
    free_fall(bodies, 2, gravity, 0.0, window);
    const BodyMotion& m = bodies[0].body.motion;
    EXPECT_LT((m.position - (x + window * v + 0.5 * window * window * gravity)).norm(), 1e-15 * 10);
    EXPECT_LT((m.velocity - (v + window * gravity)).norm(), 1e-15 * 10);
    for (const int still : {1, 2}) EXPECT_EQ(bodies[still].body.motion.position, x);  // static, and not asked for
  }
}

TEST(SettleWindow, IsAsLongAsTwoBodiesTakeForTheirTravel) {
  const RunSetup s = settling();
  const Vec3 right(1, 0, 0);
  EXPECT_EQ(rigid_window_ticks(s, {}), 20);
  EXPECT_EQ(rigid_window_ticks(s, {ball(Vec3::Zero(), right)}), 20);
  // 5 mm at a relative speed of 1 m/s
  EXPECT_EQ(rigid_window_ticks(s, {ball(Vec3::Zero(), 0.4 * right), ball(Vec3(0.03, 0, 0), -0.6 * right)}), 5);
  EXPECT_EQ(rigid_window_ticks(s, {ball(Vec3::Zero(), 100 * right), ball(Vec3(0.03, 0, 0), Vec3::Zero())}), 1);
  // too slow for that travel, or too far apart to meet
  EXPECT_EQ(rigid_window_ticks(s, {ball(Vec3::Zero(), 0.2 * right), ball(Vec3(0.03, 0, 0), Vec3::Zero())}), 20);
  EXPECT_EQ(rigid_window_ticks(s, {ball(Vec3::Zero(), right), ball(Vec3(0.05, 0, 0), Vec3::Zero())}), 20);
}

TEST(SettleWindow, DoesNotCountWhatCannotPassThrough) {
  const RunSetup s = settling();
  const Vec3 right(1, 0, 0), near(0.03, 0, 0);
  EXPECT_EQ(rigid_window_ticks(s, {of_static(ball(Vec3::Zero(), right)), of_static(ball(near, Vec3::Zero()))}), 20);
  RigidBody floor;
  floor.id = 2, floor.is_static = true, floor.shape = HalfSpaceShape{};
  EXPECT_EQ(rigid_window_ticks(s, {ball(Vec3::Zero(), right), Proxy(floor)}), 20);
  RunSetup none = settling();
  none.shells.clear();
  EXPECT_EQ(rigid_window_ticks(none, {ball(Vec3::Zero(), right), ball(near, Vec3::Zero())}), 20);
}

TEST(MeetsBox, WhereTheStraightPathEntersItInTime) {
  const Eigen::AlignedBox3d box(Vec3(-1, -1, 0), Vec3(1, 1, 0));
  const Vec3 down(0, 0, -2);
  EXPECT_TRUE(meets_box(box, 0.5, Vec3(0, 0, 2.5), down, 1.0 + 1e-12));   // 2 m above the grown box at 2 m/s
  EXPECT_FALSE(meets_box(box, 0.5, Vec3(0, 0, 2.5), down, 1.0 - 1e-12));  // too late
  EXPECT_FALSE(meets_box(box, 0.5, Vec3(0, 0, 2.5), -down, 10.0));        // away
  EXPECT_TRUE(meets_box(box, 0.5, Vec3(1.49, 0, 2.5), down, 2.0));        // past the edge, within the pad
  EXPECT_FALSE(meets_box(box, 0.5, Vec3(1.51, 0, 2.5), down, 2.0));
  EXPECT_TRUE(meets_box(box, 0.5, Vec3(0, 0, 0.4), -down, 1.0));  // it is there
  EXPECT_FALSE(meets_box(box, 0.5, Vec3(0, 0, 2.5), Vec3::Zero(), 1.0));
  EXPECT_FALSE(meets_box(box, 0.5, Vec3(0, 0, 2.5), down, -1.0));  // no time is left
}

TEST(Passes, WhereTheStraightPathComesNearInTime) {
  const Vec3 down(0, 0, -2), point(0.3, 0, 0);
  EXPECT_TRUE(passes(point, 0.31, Vec3(0, 0, 2), down, 1.0));
  EXPECT_FALSE(passes(point, 0.29, Vec3(0, 0, 2), down, 1.0));  // through a hole about the point
  EXPECT_FALSE(passes(point, 0.31, Vec3(0, 0, 2), down, 0.8));  // too late
  EXPECT_FALSE(passes(point, 0.31, Vec3(0, 0, 2), -down, 9.0));
  EXPECT_TRUE(passes(point, 0.31, Vec3(0.2, 0, 0.2), -down, 9.0));  // it is there
  EXPECT_TRUE(passes(point, 0.31, Vec3(0.2, 0, 0.2), Vec3::Zero(), 9.0));
}

TEST(SettleWindow, IsThatOfTheLeastThickness) {
  RunSetup s = settling();
  const Vec3 right(1, 0, 0);
  const std::vector<Proxy> bodies{ball(Vec3::Zero(), 0.4 * right), ball(Vec3(0.03, 0, 0), -0.6 * right)};
  const auto shell = [](double thickness, const ThicknessFactor& factor) {
    return make_shell("p", plate(0.2, 0.2, 4, 4, Vec3::Zero(), Quat::Identity()), thickness, glass(), 2, 2, {}, {}, {},
                      factor);
  };
  s.shells[0].model = shell(0.008, {});
  EXPECT_EQ(rigid_window_ticks(s, bodies), 10);
  s.shells[0].model = shell(0.004, [](const Patch&, const Vec2&) { return 2.0; });
  EXPECT_EQ(rigid_window_ticks(s, bodies), 10);
  s.shells[0].model = shell(0.008, [](const Patch&, const Vec2& p) { return p.x() < 0.1 ? 1.0 : 0.5; });
  EXPECT_EQ(rigid_window_ticks(s, bodies), 5);
}
