#include "rigid/engine/ode_engine.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <limits>

#include "coupler/core/error.h"
#include "tests/rigid/shards.h"

namespace sunder::rigid {
namespace {

using namespace testing;  // NOLINT: the helpers of this folder

constexpr double kWindow = 0.25e-3;  // [s]

bool same_bits(const BodyMotion& a, const BodyMotion& b) {
  return 0 == std::memcmp(a.position.data(), b.position.data(), 3 * sizeof(double)) &&
         0 == std::memcmp(a.orientation.coeffs().data(), b.orientation.coeffs().data(), 4 * sizeof(double)) &&
         0 == std::memcmp(a.velocity.data(), b.velocity.data(), 3 * sizeof(double)) &&
         0 == std::memcmp(a.angular_momentum.data(), b.angular_momentum.data(), 3 * sizeof(double));
}

void expect_same_bits(const std::vector<EngineState>& a, const std::vector<EngineState>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].id, b[i].id);
    EXPECT_TRUE(same_bits(a[i].motion, b[i].motion)) << a[i].id;
  }
}

RigidBody small_shard(BodyId id) { return plate(id, {{Vec2(0, 0), Vec2(0.02, 0.003), Vec2(0.007, 0.013)}}, 0.003); }

TEST(OdeEngine, ReturnsPredictedStatesToTheBitWhereNothingTouches) {
  for (double spin : {0.0, 3.0, 300.0, 4000.0, 20000.0}) {  // up to 5 rad per window
    OdeEngine engine;
    Caller caller(engine, kWindow, kGravity);
    RigidBody shard = small_shard(7), near = small_shard(8);
    shard.motion.position = Vec3(0.1, -0.2, 5.0);
    shard.motion.velocity = Vec3(1.0 / 3.0, 2.0, 3.0);
    shard.motion.angular_momentum = shard.apply_inertia(spin * Vec3(0.3, 0.5, 0.8));
    near.motion = shard.motion;
    // Near one another but never in contact. Without spin the solver has rows for them.
    near.motion.position.z() += spin == 0.0 ? 0.0035 : 0.03;
    caller.add(shard);
    caller.add(near);
    caller.add(half_space(1));
    for (int i = 0; i < 200; ++i) {
      caller.window();
      EXPECT_TRUE(same_bits(caller.predicted()[0].motion, caller.body(7).motion));
      EXPECT_TRUE(same_bits(caller.predicted()[1].motion, caller.body(8).motion));
    }
  }
}

TEST(OdeEngine, SpheresCollideByTheirRestitution) {
  for (double restitution : {0.0, 0.4, 1.0}) {
    OdeEngine engine;
    engine.set_contact_laws({{0, 0, 0.3, restitution}});
    Caller caller(engine, 1e-3, 0.0);
    RigidBody a = sphere(1, 0.05, 0.3), b = sphere(2, 0.03, 0.7);
    a.motion.velocity = Vec3(2.0, 0, 0);
    b.motion.position = Vec3(0.1013, 0, 0);
    b.motion.velocity = Vec3(-1.1, 0, 0);
    caller.add(a);
    caller.add(b);
    caller.run(0.1);
    const double va = caller.body(1).motion.velocity.x(), vb = caller.body(2).motion.velocity.x();
    EXPECT_NEAR(0.3 * va + 0.7 * vb, 0.3 * 2.0 - 0.7 * 1.1, 1e-12);  // round-off
    EXPECT_NEAR(vb - va, restitution * 3.1, 1e-7) << restitution;    // the solver's softness, 1e-9 of the change
  }
}

TEST(OdeEngine, KeepsMomentumWhenAShardIsHitAside) {
  OdeEngine engine;
  Caller caller(engine, kWindow, 0.0);
  RigidBody shard = small_shard(1), ball = sphere(2, 0.005, 0.004);
  shard.motion.position = Vec3(0.004, 0.003, 0.0);
  shard.motion.angular_momentum = shard.apply_inertia(Vec3(3, 2, -5));
  ball.motion.position = Vec3(0.007, 0.002, 0.02);
  ball.motion.velocity = Vec3(0.2, 0.1, -1.0);
  caller.add(shard);
  caller.add(ball);
  const auto linear = [&] {
    return Vec3(shard.mass * caller.body(1).motion.velocity + ball.mass * caller.body(2).motion.velocity);
  };
  const auto angular = [&] {
    Vec3 sum = Vec3::Zero();
    for (const auto& [id, b] : caller.bodies())
      sum += b.motion.angular_momentum + b.mass * b.motion.position.cross(b.motion.velocity);
    return sum;
  };
  const Vec3 p = linear(), l = angular();
  caller.run(0.1);
  EXPECT_GT((caller.body(2).motion.velocity - ball.motion.velocity).norm(), 0.05);  // they collided
  EXPECT_LT((linear() - p).norm(), 1e-12 * p.norm());
  // the impulse acts at the start of the window, velocities are those at its end: error O(H)
  EXPECT_LT((angular() - l).norm(), 0.02 * l.norm());
}

TEST(OdeEngine, BallComesToRestOnAHalfSpace) {
  OdeEngine engine;
  Caller caller(engine, kWindow, kGravity);
  RigidBody ball = sphere(1, 0.04, 0.5);
  ball.motion.position = Vec3(0, 0, 0.14);
  caller.add(ball);
  caller.add(half_space(2));
  caller.run(1.0);
  EXPECT_NEAR(caller.body(1).motion.position.z(), 0.04, 1e-6);
  EXPECT_LT(caller.body(1).motion.velocity.norm(), 1e-6);
}

TEST(OdeEngine, BallReboundsByItsRestitution) {
  OdeEngine engine;
  engine.set_contact_laws({{3, 5, 0.3, 0.5}});
  Caller caller(engine, kWindow, kGravity);
  RigidBody ball = sphere(1, 0.04, 0.5), floor = half_space(2);
  ball.motion.position = Vec3(0, 0, 0.24);
  ball.contact_group = 5;
  floor.contact_group = 3;
  caller.add(ball);
  caller.add(floor);
  double before = 0.0, after = 0.0;
  for (int i = 0; i < 1000 && after <= 0.0; ++i) {
    before = caller.body(1).motion.velocity.z();
    caller.window();
    after = caller.body(1).motion.velocity.z();
  }
  EXPECT_NEAR(-after / before, 0.5, 1e-3);  // O(g H / v)
  caller.run(after / kGravity);
  EXPECT_NEAR(caller.body(1).motion.position.z() - 0.04, 0.25 * 0.2, 0.02 * 0.05);
}

TEST(OdeEngine, BoxSlidesToRestByFriction) {
  for (double angle : {0.0, 0.7}) {  // along the box and askew
    OdeEngine engine;
    engine.set_contact_laws({{0, 1, 0.3, 0.0}});
    Caller caller(engine, kWindow, kGravity);
    RigidBody slider = box(1, Vec3(0.1, 0.1, 0.01), 1.0), floor = half_space(2);
    slider.motion.position = Vec3(0, 0, 0.01);
    slider.motion.velocity = Vec3(std::cos(angle), std::sin(angle), 0.0);
    floor.contact_group = 1;
    caller.add(slider);
    caller.add(floor);
    caller.run(0.6);
    const Vec3 end = caller.body(1).motion.position;
    const double expected = 1.0 / (2.0 * 0.3 * kGravity);
    EXPECT_NEAR(std::hypot(end.x(), end.y()), expected, 0.02 * expected) << angle;
    EXPECT_NEAR(std::atan2(end.y(), end.x()), angle, 0.02);
    EXPECT_LT(caller.body(1).motion.velocity.norm(), 1e-6);
  }
}

/// Distance that a box slides down a slope of this angle in half a second [m].
double slid(double degrees, double azimuth, double friction, bool on_box) {
  OdeEngine engine;
  engine.set_contact_laws({{0, 1, friction, 0.0}});
  Caller caller(engine, kWindow, kGravity);
  const Vec3 axis(-std::sin(azimuth), std::cos(azimuth), 0.0);
  const Quat tilt = rotation_from_vector(degrees * EIGEN_PI / 180.0 * axis);
  RigidBody slider = box(1, Vec3(0.05, 0.05, 0.01), 1.0);
  slider.motion.orientation = tilt;
  slider.motion.position = tilt * Vec3(0, 0, 0.01);
  RigidBody slope = on_box ? box(2, Vec3(5, 5, 0.1), 1.0) : half_space(2);
  slope.is_static = true;
  slope.motion.orientation = tilt;
  if (on_box) slope.motion.position = tilt * Vec3(0, 0, -0.1);
  slope.contact_group = 1;
  caller.add(slider);
  caller.add(slope);
  caller.run(0.5);
  return (caller.body(1).motion.position - slider.motion.position).norm();
}

TEST(OdeEngine, BoxStartsToSlideAtTheFrictionAngle) {
  const double friction = 0.5, angle = std::atan(friction) * 180.0 / EIGEN_PI;
  for (double azimuth : {0.0, 0.4, 0.785})
    for (bool on_box : {false, true}) {
      EXPECT_LT(slid(angle - 0.2, azimuth, friction, on_box), 1e-6) << azimuth;
      const double steeper = angle + 0.2, a = steeper * EIGEN_PI / 180.0;
      const double free = 0.5 * kGravity * (std::sin(a) - friction * std::cos(a)) * 0.25;  // [m] within 0.5 s
      EXPECT_NEAR(slid(steeper, azimuth, friction, on_box), free, 0.02 * free) << azimuth;
    }
}

TEST(OdeEngine, StackOfTwentyPlatesStands) {
  for (double window : {1e-3, 0.25e-3}) {  // solved exactly; sweeps would need a warm start
    OdeEngine engine;
    Caller caller(engine, window, kGravity);
    caller.add(half_space(100));
    const double thick = 3e-3;
    for (int i = 0; i < 20; ++i) {
      RigidBody p = plate(static_cast<BodyId>(1 + i), {rectangle(-0.05, -0.04, 0.05, 0.04)}, thick);
      p.motion.position.z() = (i + 0.5) * thick + 1e-5 * i;
      caller.add(p);
    }
    caller.run(400 * window);
    for (int i = 0; i < 20; ++i) {
      const BodyMotion& m = caller.body(static_cast<BodyId>(1 + i)).motion;
      EXPECT_NEAR(m.position.z(), (i + 0.5) * thick, 1e-5) << i;  // at most the overlap that stays, at each face
      EXPECT_LT(std::hypot(m.position.x(), m.position.y()), 1e-5) << i;
      EXPECT_LT(m.velocity.norm(), 1e-5) << i;
    }
  }
}

TEST(OdeEngine, FastPlatesDoNotPassTheFloorNorOneAnother) {
  for (double tilt : {0.0, 0.1, 0.8, 1.4})
    for (bool on_plate : {false, true})
      for (double window : {0.25e-3, 1e-3}) {
        OdeEngine engine;
        Caller caller(engine, window, kGravity);
        RigidBody falling = plate(1, {rectangle(-0.05, -0.04, 0.05, 0.04)}, 4e-3);
        falling.motion.position.z() = 0.1;
        falling.motion.orientation = rotation_from_vector(tilt * Vec3(0.6, 0.8, 0)) * falling.motion.orientation;
        falling.motion.velocity.z() = -10.0;
        RigidBody below = half_space(2);
        if (on_plate) {
          below = plate(2, {rectangle(-0.5, -0.5, 0.5, 0.5)}, 4e-3);
          below.motion.position.z() = -2e-3;
          below.is_static = true;
        }
        caller.add(falling);
        caller.add(below);
        double lowest = 0.0;
        for (int i = 0; i < std::lround(1.0 / window); ++i) {
          caller.window();
          lowest = std::min(lowest, lowest_corner(caller.body(1)));
        }
        EXPECT_GT(lowest, -0.5e-3) << tilt << " " << on_plate << " " << window;  // an eighth of its thickness
        EXPECT_NEAR(caller.body(1).motion.position.z(), 2e-3, 2e-5) << tilt << " " << on_plate << " " << window;
      }
}

TEST(OdeEngine, NewbornShardsGainNoEnergy) {
  for (double overlap : {0.0, 0.1e-3, 0.5e-3}) {
    OdeEngine engine;
    Caller caller(engine, kWindow, 0.0);
    const double a = 0.05, o = 0.5 * overlap;
    std::map<BodyId, Vec3> born;
    for (int j = 0; j < 5; ++j)
      for (int i = 0; i < 5; ++i) {
        RigidBody shard = plate(static_cast<BodyId>(1 + 5 * j + i),
                                {rectangle(i * a - o, j * a - o, (i + 1) * a + o, (j + 1) * a + o)}, 0.004);
        shard.is_static = i == 2 && j == 2;  // the rest of a pane
        caller.add(shard);
        born[shard.id] = shard.motion.position;
      }
    RigidBody ball = sphere(100, 0.03, 0.5);  // overlaps four shards
    ball.motion.position = Vec3(a, a, 0.002 + 0.03 - overlap);
    caller.add(ball);
    double most = 0.0;
    for (int i = 0; i < 800; ++i) {
      caller.window();
      most = std::max(most, caller.kinetic_energy());
    }
    EXPECT_LT(most, 1e-6) << overlap;  // [J]
    for (const auto& [id, position] : born)
      if (caller.bodies().count(id) > 0) {
        EXPECT_LT((caller.body(id).motion.position - position).norm(), 1e-4);
      }
  }
}

TEST(OdeEngine, OverlapAtBirthIsForgottenOnceApart) {
  OdeEngine engine;
  Caller caller(engine, kWindow, 0.0);
  RigidBody a = box(1, Vec3::Constant(0.02), 1.0), b = box(2, Vec3::Constant(0.02), 1.0);
  b.motion.position = Vec3(0.039, 0, 0);  // 1 mm inside
  b.motion.velocity = Vec3(0.5, 0, 0);
  caller.add(a);
  caller.add(b);
  caller.run(0.003);
  EXPECT_EQ(Vec3(0.5, 0, 0), caller.body(2).motion.velocity);
  RigidBody c = box(3, Vec3::Constant(0.02), 1000.0);  // pushes it back: they meet at their faces
  c.motion.position = Vec3(0.081, 0, 0);
  c.motion.velocity = Vec3(-0.5, 0, 0);
  caller.add(c);
  caller.run(0.2);
  EXPECT_NEAR(caller.body(2).motion.position.x() - caller.body(1).motion.position.x(), 0.04, 1e-5);
}

TEST(OdeEngine, ThrownShardsComeToRestOnTheFloor) {
  OdeEngine engine;
  Caller caller(engine, kWindow, kGravity);
  caller.add(half_space(1000));
  for (const RigidBody& shard : thrown_shards(60, 1)) caller.add(shard);
  const double before = caller.energy();
  double most = -1e300, lowest = 0.0, jump = 0.0, last = before;
  for (int i = 0; i < 6000; ++i) {
    caller.window();
    const double now = caller.energy();
    most = std::max(most, now);
    jump = std::max(jump, now - last);
    last = now;
    if (i % 10 == 0)
      for (const auto& [id, b] : caller.bodies()) lowest = std::min(lowest, lowest_corner(b));
  }
  EXPECT_LT(most, before + 1e-9);
  EXPECT_LT(jump, 1e-6);       // poses moved out of overlaps rise by a micrometre
  EXPECT_GT(lowest, -0.3e-3);  // look-ahead follows the tangents of turning corners
  for (const auto& [id, b] : caller.bodies()) {
    EXPECT_LT(b.motion.velocity.norm(), 0.05) << id;
    EXPECT_GT(lowest_corner(b), -0.1e-3) << id;
    EXPECT_LT(b.motion.position.z(), 0.5) << id;
  }
}

TEST(OdeEngine, SliversAndCompoundsKeepTheirSize) {
  for (double thickness : {0.2e-3, 0.6e-3, 4e-3}) {
    OdeEngine engine;
    Caller caller(engine, kWindow, kGravity);
    RigidBody shelf = plate(1, {rectangle(0, 0, 0.1, 0.05), rectangle(0, 0.05, 0.05, 0.1)}, thickness);
    shelf.is_static = true;
    RigidBody first = sphere(2, 0.01, 0.02), second = sphere(3, 0.01, 0.02), beside = sphere(4, 0.01, 0.02);
    first.motion.position = Vec3(0.08, 0.03, 0.02);
    second.motion.position = Vec3(0.02, 0.08, 0.02);
    beside.motion.position = Vec3(0.08, 0.08, 0.02);  // in the notch of the L
    for (const RigidBody& b : {shelf, first, second, beside}) caller.add(b);
    caller.run(0.2);
    EXPECT_NEAR(caller.body(2).motion.position.z(), 0.01 + 0.5 * thickness, 1e-6) << thickness;
    EXPECT_NEAR(caller.body(3).motion.position.z(), 0.01 + 0.5 * thickness, 1e-6) << thickness;
    EXPECT_LT(caller.body(4).motion.position.z(), -0.1) << thickness;
  }
}

TEST(OdeEngine, FastSpinnersLandWithoutGainingEnergy) {
  for (double spin : {1000.0, 4000.0, 12000.0}) {  // 0.25, 1 and 3 rad per window
    OdeEngine engine;
    Caller caller(engine, kWindow, kGravity);
    RigidBody shard = small_shard(1);
    shard.motion.position = Vec3(0, 0, 0.05);
    shard.motion.angular_momentum = shard.apply_inertia(spin * Vec3(0.6, 0.0, 0.8));
    caller.add(shard);
    caller.add(half_space(2));
    // The caller's midpoint rule drifts at such a turn, so count the engine's changes only.
    const double before = caller.energy();
    double gained = 0.0, lost = 0.0;
    for (int i = 0; i < 8000; ++i) {
      caller.window();
      const double change = caller.energy() - caller.predicted_energy();
      (change > 0.0 ? gained : lost) += change;
    }
    EXPECT_LT(gained, 0.01 * before) << spin;
    EXPECT_LT(lost, -0.3 * before) << spin;
    EXPECT_GT(lowest_corner(caller.body(1)), -2e-3) << spin;
  }
}

TEST(OdeEngine, SameCallsGiveTheSameBits) {
  std::vector<std::vector<EngineState>> results;
  for (int run = 0; run < 2; ++run) {
    std::vector<std::unique_ptr<int[]>> heap;  // other addresses in the second run
    if (run == 1)
      for (int i = 0; i < 50; ++i) heap.push_back(std::make_unique<int[]>(10 + 1000 * i));
    OdeEngine engine;
    Caller caller(engine, kWindow, kGravity);
    std::vector<RigidBody> bodies = thrown_shards(24, 5);
    bodies.push_back(half_space(1000));
    if (run == 1) std::reverse(bodies.begin(), bodies.end());  // the order of add() does not matter either
    for (const RigidBody& b : bodies) caller.add(b);
    caller.run(0.3);
    results.push_back(engine.states());
  }
  expect_same_bits(results[0], results[1]);
}

TEST(OdeEngine, ARestoredEngineContinuesToTheBit) {
  OdeEngine engine;
  Caller caller(engine, kWindow, kGravity);
  std::vector<RigidBody> bodies = thrown_shards(24, 5);
  bodies.push_back(half_space(1000));
  RigidBody sunk = box(2000, Vec3::Constant(0.05), 1.0);  // keeps 5 mm of overlap with the floor: a saved allowance
  sunk.motion.position = Vec3(-1, 0, 0.045);
  bodies.push_back(sunk);
  for (const RigidBody& b : bodies) caller.add(b);
  caller.run(0.1);  // during impacts
  const std::string caches = engine.save();
  OdeEngine other;
  for (RigidBody b : bodies) {
    if (!b.is_static) b.motion = caller.body(b.id).motion;
    other.add(b);
  }
  std::vector<PredictedState> motions;
  for (const EngineState& s : engine.states()) motions.push_back({s.id, s.motion});
  other.restore(caches, motions);
  for (int i = 0; i < 400; ++i) {
    caller.window();
    other.advance(kWindow, caller.predicted(), {});
  }
  expect_same_bits(engine.states(), other.states());
  EXPECT_NEAR(caller.body(2000).motion.position.z(), 0.045, 1e-5);
  // and restored itself, the engine takes the same windows again
  const auto there = engine.states();
  engine.restore(caches, motions);
  const auto start = engine.states();
  for (std::size_t i = 0; i < motions.size(); ++i) EXPECT_TRUE(same_bits(start[i].motion, motions[i].motion));
}

}  // namespace
}  // namespace sunder::rigid
