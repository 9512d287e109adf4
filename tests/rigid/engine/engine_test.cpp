// What engines promise alike: flight, collisions, friction, births, rest, repetition.
#include "rigid/engine/engine.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/rigid/every_engine.h"

namespace sunder::rigid {
namespace {

using namespace testing;  // NOLINT: the helpers of this folder

INSTANTIATE_TEST_SUITE_P(Of, EveryEngine, ::testing::Values(kBullet, kOde), name_of);

TEST_P(EveryEngine, IsMadeByName) {
  const EngineInfo info = make()->info();
  EXPECT_EQ(info.name, GetParam().name);
  EXPECT_TRUE(info.version.starts_with(GetParam().version)) << info.version;
}

TEST_P(EveryEngine, ReturnsPredictedStatesToTheBitWhereNothingTouches) {
  for (double spin :
       {0.0, 3.0, 300.0, 4000.0, 20000.0}) {  // up to 5 rad per window, more than Bullet's own integration allows
    const auto engine = make();
    Caller caller(*engine, kWindow, kGravity);
    RigidBody shard = small_shard(7), near = small_shard(8);
    shard.motion.position = Vec3(0.1, -0.2, 5.0);
    shard.motion.velocity = Vec3(1.0 / 3.0, 2.0, 3.0);
    shard.motion.angular_momentum = shard.apply_inertia(spin * Vec3(0.3, 0.5, 0.8));
    near.motion = shard.motion;
    near.motion.position.z() += spin == 0.0 ? GetParam().apart : 0.03;
    caller.add(shard);
    caller.add(near);
    caller.add(half_space(1));
    for (int i = 0; i < 200; ++i) {
      caller.window();
      EXPECT_EQ(bits(caller.predicted()[0].motion), bits(caller.body(7).motion));
      EXPECT_EQ(bits(caller.predicted()[1].motion), bits(caller.body(8).motion));
    }
  }
}

TEST_P(EveryEngine, KeepsTheSpinMomentumOfASmallShard) {
  const auto engine = make();
  Caller caller(*engine, kWindow, 0.0);
  RigidBody shard = small_shard(1);
  shard.motion.angular_momentum = shard.apply_inertia(Vec3(30, 50, 5));
  caller.add(shard);
  const Vec3 before = shard.motion.angular_momentum;
  const double energy = shard.kinetic_energy();
  caller.run(1.0);
  EXPECT_EQ(before, caller.body(1).motion.angular_momentum);
  EXPECT_NEAR(caller.kinetic_energy(), energy, 1e-8 * energy);  // the caller's free rotation errs by no more
}

TEST_P(EveryEngine, SpheresCollideByTheirRestitution) {
  for (double restitution : {0.0, 0.4, 1.0}) {
    const auto engine = make();
    engine->set_contact_laws({{0, 0, 0.3, restitution}});
    Caller caller(*engine, 1e-3, 0.0);
    RigidBody a = sphere(1, 0.05, 0.3), b = sphere(2, 0.03, 0.7);
    a.motion.velocity = Vec3(2.0, 0, 0);
    b.motion.position = Vec3(0.1013, 0, 0);
    b.motion.velocity = Vec3(-1.1, 0, 0);
    caller.add(a);
    caller.add(b);
    caller.run(0.1);
    const double va = caller.body(1).motion.velocity.x(), vb = caller.body(2).motion.velocity.x();
    EXPECT_NEAR(0.3 * va + 0.7 * vb, 0.3 * 2.0 - 0.7 * 1.1, 1e-12);  // round-off
    EXPECT_NEAR(vb - va, restitution * 3.1, GetParam().solved) << restitution;
  }
}

TEST_P(EveryEngine, KeepsMomentumWhenAShardIsHitAside) {
  const auto engine = make();
  Caller caller(*engine, kWindow, 0.0);
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

TEST_P(EveryEngine, BallComesToRestOnAHalfSpace) {
  const auto engine = make();
  Caller caller(*engine, kWindow, kGravity);
  RigidBody ball = sphere(1, 0.04, 0.5);
  ball.motion.position = Vec3(0, 0, 0.14);
  caller.add(ball);
  caller.add(half_space(2));
  caller.run(1.0);
  EXPECT_NEAR(caller.body(1).motion.position.z(), 0.04, GetParam().gap);
  EXPECT_LT(caller.body(1).motion.velocity.norm(), GetParam().still);
}

TEST_P(EveryEngine, BallReboundsByItsRestitution) {
  const auto engine = make();
  engine->set_contact_laws({{3, 5, 0.3, 0.5}});
  Caller caller(*engine, kWindow, kGravity);
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
  EXPECT_NEAR(-after / before, 0.5, 2.0 * kGravity * kWindow / -before);  // O(g H / v)
  caller.run(after / kGravity);
  EXPECT_NEAR(caller.body(1).motion.position.z() - 0.04, 0.25 * 0.2, 0.02 * 0.05);
}

// A ball slides over a floor and a box without friction, and turns. Each impulse goes through its centre, so its spin
// stays. A contact that turns with the ball would have an arm of |w| H r, 2.5 mm here.
TEST_P(EveryEngine, ASpinningBallReboundsWithItsSpin) {
  RigidBody brick = box(2, Vec3(1.0, 1.0, 0.1), 1.0);
  brick.is_static = true, brick.mass = 0.0, brick.principal_inertia = Vec3::Zero();
  brick.motion.position = Vec3(0, 0, -0.1);
  for (const RigidBody& below : {half_space(2), brick}) {
    const auto engine = make();
    engine->set_contact_laws({{0, 0, 0.0, 0.5}});
    Caller caller(*engine, 1e-3, 0.0);
    RigidBody ball = sphere(1, 0.05, 0.5);
    ball.motion.position = Vec3(0, 0, 0.0512);
    ball.motion.velocity = Vec3(1.0, 0, -2.0);
    const Vec3 spin(3.0, 50.0, -7.0);
    ball.motion.angular_momentum = ball.apply_inertia(spin);
    caller.add(ball);
    caller.add(below);
    caller.run(3e-3);
    EXPECT_NEAR((caller.body(1).angular_velocity() - spin).norm(), 0.0, 1e3 * GetParam().solved) << below.name;
    EXPECT_NEAR((caller.body(1).motion.velocity - Vec3(1.0, 0, 1.0)).norm(), 0.0, 1e2 * GetParam().solved)
        << below.name;
  }
}

TEST_P(EveryEngine, BallsReboundTheSameBesideOthersThatTouch) {
  // The first and last body are boxes in contact, one island. Each ball is an island of its own.
  std::vector<BodyMotion> alone;
  for (const bool beside : {false, true}) {
    const auto engine = make();
    engine->set_contact_laws({{3, 5, 0.3, 0.5}});
    Caller caller(*engine, kWindow, kGravity);
    RigidBody floor = half_space(1);
    floor.contact_group = 3;
    caller.add(floor);
    for (int k = 0; k < 4; ++k) {
      RigidBody ball = sphere(3 + k, 0.04, 0.5);
      ball.contact_group = 5;
      ball.motion.position = Vec3(0.2 * k, 0, 0.05 + 0.01 * k);
      ball.motion.velocity = Vec3(0, 0, -1.0);
      caller.add(ball);
    }
    for (const BodyId id : {2, 9}) {
      RigidBody low = box(id, Vec3(0.1, 0.1, 0.01), 1.0);
      low.motion.position = Vec3(-1.0, 0, id == 2 ? 0.01 : 0.03);
      if (beside) caller.add(low);
    }
    caller.run(0.1);
    for (int k = 0; k < 4; ++k) {
      const BodyMotion m = caller.body(3 + k).motion;
      EXPECT_GT(m.position.z(), 0.042) << k;
      if (!beside) alone.push_back(m);
      EXPECT_NEAR(m.position.z(), alone[k].position.z(), 1e-12) << k;
    }
  }
}

TEST_P(EveryEngine, BoxSlidesToRestByFriction) {
  for (double angle : {0.0, 0.7}) {  // along the box and askew
    const auto engine = make();
    engine->set_contact_laws({{0, 1, 0.3, 0.0}});
    Caller caller(*engine, kWindow, kGravity);
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
    EXPECT_LT(caller.body(1).motion.velocity.norm(), GetParam().still);
  }
}

TEST_P(EveryEngine, NewbornShardsGainNoEnergy) {
  for (double overlap : {0.0, 0.1e-3, 0.5e-3}) {
    const auto engine = make();
    Caller caller(*engine, kWindow, 0.0);
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
    EXPECT_LT(most, 1e-6) << overlap;  // [J]; Bullet's defaults give up to 0.07 J
    for (const auto& [id, position] : born)
      if (caller.bodies().count(id) > 0) {
        EXPECT_LT((caller.body(id).motion.position - position).norm(), 1e-4);
      }
  }
}

TEST_P(EveryEngine, OverlapAtBirthIsForgottenOnceApart) {
  const auto engine = make();
  Caller caller(*engine, kWindow, 0.0);
  RigidBody a = box(1, Vec3::Constant(0.02), 1.0), b = box(2, Vec3::Constant(0.02), 1.0);
  b.motion.position = Vec3(0.039, 0, 0);  // 1 mm inside
  b.motion.velocity = Vec3(0.5, 0, 0);
  caller.add(a);
  caller.add(b);
  caller.run(0.003);
  EXPECT_EQ(Vec3(0.5, 0, 0), caller.body(2).motion.velocity);
  // 0.5 mm apart, a third body pushes it back: they meet at their faces
  RigidBody c = box(3, Vec3::Constant(0.02), 1000.0);
  c.motion.position = Vec3(0.081, 0, 0);
  c.motion.velocity = Vec3(-0.5, 0, 0);
  caller.add(c);
  caller.run(0.2);
  EXPECT_NEAR(caller.body(2).motion.position.x() - caller.body(1).motion.position.x(), 0.04, 10.0 * GetParam().gap);
}

TEST_P(EveryEngine, ThrownShardsComeToRestOnTheFloor) {
  const auto engine = make();
  Caller caller(*engine, kWindow, kGravity);
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
  EXPECT_LT(jump, GetParam().jump);
  EXPECT_GT(lowest, -GetParam().sunk);
  for (const auto& [id, b] : caller.bodies()) {
    EXPECT_LT(b.motion.velocity.norm(), 0.05) << id;
    EXPECT_GT(lowest_corner(b), -0.1e-3) << id;
    EXPECT_LT(b.motion.position.z(), 0.5) << id;
  }
}

TEST_P(EveryEngine, SliversAndCompoundsKeepTheirSize) {
  for (double thickness : {0.2e-3, 0.6e-3, 4e-3}) {  // thinner than Bullet's margin, than two, and usual
    const auto engine = make();
    Caller caller(*engine, kWindow, kGravity);
    RigidBody shelf = plate(1, {rectangle(0, 0, 0.1, 0.05), rectangle(0, 0.05, 0.05, 0.1)}, thickness);
    shelf.is_static = true;
    RigidBody first = sphere(2, 0.01, 0.02), second = sphere(3, 0.01, 0.02), beside = sphere(4, 0.01, 0.02);
    first.motion.position = Vec3(0.08, 0.03, 0.02);
    second.motion.position = Vec3(0.02, 0.08, 0.02);
    beside.motion.position = Vec3(0.08, 0.08, 0.02);  // in the notch of the L
    for (const RigidBody& b : {shelf, first, second, beside}) caller.add(b);
    caller.run(0.2);
    EXPECT_NEAR(caller.body(2).motion.position.z(), 0.01 + 0.5 * thickness, GetParam().hull) << thickness;
    EXPECT_NEAR(caller.body(3).motion.position.z(), 0.01 + 0.5 * thickness, GetParam().hull) << thickness;
    EXPECT_LT(caller.body(4).motion.position.z(), -0.1) << thickness;
  }
}

TEST_P(EveryEngine, FastSpinnersLandWithoutGainingEnergy) {
  for (double spin : {1000.0, 4000.0, 12000.0}) {  // 0.25, 1 and 3 rad per window
    const auto engine = make();
    Caller caller(*engine, kWindow, kGravity);
    RigidBody shard = small_shard(1);
    shard.motion.position = Vec3(0, 0, 0.05);
    shard.motion.angular_momentum = shard.apply_inertia(spin * Vec3(0.6, 0.0, 0.8));
    caller.add(shard);
    caller.add(half_space(2));
    // Count the engine's changes only.
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

TEST_P(EveryEngine, SameCallsGiveTheSameBits) {
  std::vector<std::string> results;
  for (int run = 0; run < 2; ++run) {
    std::vector<std::unique_ptr<int[]>> heap;  // other addresses in the second run
    if (run == 1)
      for (int i = 0; i < 50; ++i) heap.push_back(std::make_unique<int[]>(10 + 1000 * i));
    const auto engine = make();
    Caller caller(*engine, kWindow, kGravity);
    std::vector<RigidBody> bodies = thrown_shards(24, 5);
    bodies.push_back(half_space(1000));
    if (run == 1) std::reverse(bodies.begin(), bodies.end());  // the order of add() does not matter either
    for (const RigidBody& b : bodies) caller.add(b);
    caller.run(0.3);
    results.push_back(bits(*engine));
  }
  EXPECT_EQ(results[0], results[1]);
}

TEST_P(EveryEngine, ARestoredEngineContinuesToTheBit) {
  const auto engine = make();
  Caller caller(*engine, kWindow, kGravity);
  std::vector<RigidBody> bodies = thrown_shards(24, 5);
  bodies.push_back(half_space(1000));
  RigidBody sunk = box(2000, Vec3::Constant(0.05), 1.0);  // keeps 5 mm of overlap with the floor: a saved allowance
  sunk.motion.position = Vec3(-1, 0, 0.045);
  bodies.push_back(sunk);
  for (const RigidBody& b : bodies) caller.add(b);
  caller.run(0.1);  // during impacts
  const std::string caches = engine->save();
  const auto other = make();
  for (RigidBody b : bodies) {
    if (!b.is_static) b.motion = caller.body(b.id).motion;
    other->add(b);
  }
  std::vector<PredictedState> motions;
  for (const EngineState& s : engine->states()) motions.push_back({s.id, s.motion});
  other->restore(caches, motions);
  for (int i = 0; i < 400; ++i) {
    caller.window();
    other->advance(kWindow, caller.predicted(), {});
  }
  EXPECT_EQ(bits(*engine), bits(*other));
  EXPECT_NEAR(caller.body(2000).motion.position.z(), 0.045, 10.0 * GetParam().gap);
  // and restored itself, the engine takes the same windows again
  engine->restore(caches, motions);
  std::string saved;
  for (const PredictedState& m : motions) saved += bits(m.motion);
  EXPECT_EQ(bits(*engine), saved);
}

TEST_P(EveryEngine, LinkedBodiesDoNotCollide) {
  for (bool linked : {false, true}) {
    const auto engine = make();
    Caller caller(*engine, 1e-3, 0.0);
    RigidBody a = box(1, Vec3::Constant(0.05), 1.0), b = box(2, Vec3::Constant(0.05), 1.0);
    b.motion.position.x() = 0.3;
    b.motion.velocity.x() = -2.0;
    caller.add(a);
    caller.add(b);
    if (linked)
      engine->add_joint([] {  // slides along x
        const Quat axis = rotation_from_vector(Vec3(0, EIGEN_PI / 2.0, 0));
        return Joint{1, "joint", Joint::Kind::kSlider, 1, 2, {Vec3(0.15, 0, 0), axis}, {Vec3(-0.15, 0, 0), axis}};
      }());
    caller.run(0.15);
    const double apart = caller.body(2).motion.position.x() - caller.body(1).motion.position.x();
    if (linked)
      EXPECT_NEAR(apart, 0.0, 1e-9);  // right through
    else
      EXPECT_NEAR(apart, 0.1, 1e-5);
  }
}

TEST(EngineNames, AreThoseThatAreMadeAndOthersAreRefused) {
  for (const std::string& name : engine_names()) EXPECT_EQ(make_engine(name)->info().name, name);
  EXPECT_EQ(kind_of([] { make_engine("bulet"); }), "unknown_engine");
}

}  // namespace
}  // namespace sunder::rigid
