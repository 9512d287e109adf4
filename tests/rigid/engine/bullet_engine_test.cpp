#include "rigid/engine/bullet_engine.h"

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

void expect_same_bits(const BodyMotion& a, const BodyMotion& b) {
  EXPECT_EQ(0, std::memcmp(a.position.data(), b.position.data(), 3 * sizeof(double)));
  EXPECT_EQ(0, std::memcmp(a.orientation.coeffs().data(), b.orientation.coeffs().data(), 4 * sizeof(double)));
  EXPECT_EQ(0, std::memcmp(a.velocity.data(), b.velocity.data(), 3 * sizeof(double)));
  EXPECT_EQ(0, std::memcmp(a.angular_momentum.data(), b.angular_momentum.data(), 3 * sizeof(double)));
}

RigidBody small_shard(BodyId id) { return plate(id, {{Vec2(0, 0), Vec2(0.02, 0.003), Vec2(0.007, 0.013)}}, 0.003); }

TEST(BulletEngine, ReturnsPredictedStatesToTheBitWhereNothingTouches) {
  // 4000 rad/s is 1 rad per window: more than Bullet's own integration allows
  for (double spin : {0.0, 3.0, 300.0, 4000.0, 20000.0}) {
    BulletEngine engine;
    Caller caller(engine, kWindow, kGravity);
    RigidBody shard = small_shard(7);
    shard.motion.position = Vec3(0.1, -0.2, 5.0);
    shard.motion.velocity = Vec3(1.0 / 3.0, 2.0, 3.0);
    shard.motion.angular_momentum = shard.apply_inertia(spin * Vec3(0.3, 0.5, 0.8));
    caller.add(shard);
    caller.add(half_space(1));
    for (int i = 0; i < 200; ++i) {
      caller.window();
      expect_same_bits(caller.predicted()[0].motion, caller.body(7).motion);
    }
  }
}

TEST(BulletEngine, KeepsTheSpinMomentumOfASmallShard) {
  BulletEngine engine;
  Caller caller(engine, kWindow, 0.0);
  RigidBody shard = small_shard(1);
  shard.motion.angular_momentum = shard.apply_inertia(Vec3(30, 50, 5));
  caller.add(shard);
  const Vec3 before = shard.motion.angular_momentum;
  const double energy = shard.kinetic_energy();
  caller.run(1.0);
  EXPECT_EQ(before, caller.body(1).motion.angular_momentum);
  // the midpoint rule of the caller: relative error (|w| h)^2 ~ 1e-5 per radian, bounded
  EXPECT_NEAR(caller.kinetic_energy(), energy, 1e-4 * energy);
}

TEST(BulletEngine, SpheresCollideByTheirRestitution) {
  for (double restitution : {0.0, 0.4, 1.0}) {
    BulletEngine engine;
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
    EXPECT_NEAR(vb - va, restitution * 3.1, 1e-9) << restitution;    // the solver's residual
  }
}

TEST(BulletEngine, KeepsMomentumWhenAShardIsHitAside) {
  BulletEngine engine;
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
  // the engine's impulse acts at the start of the window, velocities are those at its end: error O(H)
  EXPECT_LT((angular() - l).norm(), 0.02 * l.norm());
}

TEST(BulletEngine, BallComesToRestOnAHalfSpace) {
  BulletEngine engine;
  Caller caller(engine, kWindow, kGravity);
  RigidBody ball = sphere(1, 0.04, 0.5), floor = half_space(2);
  ball.motion.position = Vec3(0, 0, 0.14);
  caller.add(ball);
  caller.add(floor);
  caller.run(1.0);
  EXPECT_NEAR(caller.body(1).motion.position.z(), 0.04, 1e-5);           // no gap
  EXPECT_LT(caller.body(1).motion.velocity.norm(), kGravity * kWindow);  // less than one window of gravity
}

TEST(BulletEngine, BallReboundsByItsRestitution) {
  BulletEngine engine;
  engine.set_contact_laws({{3, 5, 0.3, 0.5}});
  Caller caller(engine, kWindow, kGravity);
  RigidBody ball = sphere(1, 0.04, 0.5), floor = half_space(2);
  ball.motion.position = Vec3(0, 0, 0.24);
  ball.contact_group = 5;
  floor.contact_group = 3;
  caller.add(ball);
  caller.add(floor);
  const double fall = std::sqrt(2.0 * 0.2 / kGravity);
  caller.run(fall + 0.5 * fall);  // e v / g after the impact it is at its highest
  EXPECT_NEAR(caller.body(1).motion.position.z() - 0.04, 0.25 * 0.2, 0.02 * 0.05);  // O(g H / v)
}

TEST(BulletEngine, BallsReboundTheSameBesideOthersThatTouch) {
  // The first and last body are boxes in contact, one island. Each ball is an island of its own.
  std::vector<BodyMotion> alone;
  for (const bool beside : {false, true}) {
    BulletEngine engine;
    engine.set_contact_laws({{3, 5, 0.3, 0.5}});
    Caller caller(engine, kWindow, kGravity);
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

TEST(BulletEngine, BoxSlidesToRestByFriction) {
  for (double angle : {0.0, 0.7}) {  // along the box and askew
    BulletEngine engine;
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
    EXPECT_LT(caller.body(1).motion.velocity.norm(), kGravity * kWindow);
  }
}

TEST(BulletEngine, NewbornShardsGainNoEnergy) {
  for (double overlap : {0.0, 0.1e-3, 0.5e-3}) {
    BulletEngine engine;
    Caller caller(engine, kWindow, 0.0);
    const double a = 0.05, o = 0.5 * overlap;
    std::map<BodyId, Vec3> born;
    for (int j = 0; j < 5; ++j)
      for (int i = 0; i < 5; ++i) {
        RigidBody shard = plate(static_cast<BodyId>(1 + 5 * j + i),
                                {rectangle(i * a - o, j * a - o, (i + 1) * a + o, (j + 1) * a + o)}, 0.004);
        // the middle one is static: the rest of a pane
        shard.is_static = i == 2 && j == 2;
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

TEST(BulletEngine, OverlapAtBirthIsForgottenOnceApart) {
  BulletEngine engine;
  Caller caller(engine, kWindow, 0.0);
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
  EXPECT_NEAR(caller.body(2).motion.position.x() - caller.body(1).motion.position.x(), 0.04, 1e-4);
}

TEST(BulletEngine, ThrownShardsComeToRestOnTheFloor) {
  BulletEngine engine;
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
  // poses moved out of penetration rise by 10 um, some mg * 10 um of energy
  EXPECT_LT(jump, 1e-4);
  EXPECT_GT(lowest, -1e-3);  // a third of a thickness, at impact
  for (const auto& [id, b] : caller.bodies()) {
    EXPECT_LT(b.motion.velocity.norm(), 0.05) << id;
    EXPECT_GT(lowest_corner(b), -0.1e-3) << id;
    EXPECT_LT(b.motion.position.z(), 0.5) << id;
  }
}

TEST(BulletEngine, SliversAndCompoundsKeepTheirSize) {
  for (double thickness : {0.2e-3, 0.6e-3, 4e-3}) {  // thinner than a margin, than two, and usual
    BulletEngine engine;
    Caller caller(engine, kWindow, kGravity);
    RigidBody shelf = plate(1, {rectangle(0, 0, 0.1, 0.05), rectangle(0, 0.05, 0.05, 0.1)}, thickness);
    shelf.is_static = true;
    RigidBody first = sphere(2, 0.01, 0.02), second = sphere(3, 0.01, 0.02), beside = sphere(4, 0.01, 0.02);
    first.motion.position = Vec3(0.08, 0.03, 0.02);
    second.motion.position = Vec3(0.02, 0.08, 0.02);
    beside.motion.position = Vec3(0.08, 0.08, 0.02);  // in the notch of the L
    for (const RigidBody& b : {shelf, first, second, beside}) caller.add(b);
    caller.run(0.2);
    // 2 um: Bullet computes hulls on a grid
    EXPECT_NEAR(caller.body(2).motion.position.z(), 0.01 + 0.5 * thickness, 2e-6) << thickness;
    EXPECT_NEAR(caller.body(3).motion.position.z(), 0.01 + 0.5 * thickness, 2e-6) << thickness;
    EXPECT_LT(caller.body(4).motion.position.z(), -0.1) << thickness;
  }
}

TEST(BulletEngine, FastSpinnersLandWithoutGainingEnergy) {
  for (double spin : {1000.0, 4000.0, 12000.0}) {  // 0.25, 1 and 3 rad per window
    BulletEngine engine;
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

TEST(BulletEngine, SameCallsGiveTheSameBits) {
  std::vector<std::vector<EngineState>> results;
  for (int run = 0; run < 2; ++run) {
    std::vector<std::unique_ptr<int[]>> heap;  // other addresses in the second run
    if (run == 1)
      for (int i = 0; i < 50; ++i) heap.push_back(std::make_unique<int[]>(10 + 1000 * i));
    BulletEngine engine;
    Caller caller(engine, kWindow, kGravity);
    std::vector<RigidBody> bodies = thrown_shards(24, 5);
    bodies.push_back(half_space(1000));
    if (run == 1) std::reverse(bodies.begin(), bodies.end());  // the order of add() does not matter either
    for (const RigidBody& b : bodies) caller.add(b);
    caller.run(0.3);
    results.push_back(engine.states());
  }
  ASSERT_EQ(results[0].size(), results[1].size());
  for (std::size_t i = 0; i < results[0].size(); ++i) {
    EXPECT_EQ(results[0][i].id, results[1][i].id);
    expect_same_bits(results[0][i].motion, results[1][i].motion);
  }
}

std::string kind_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    EXPECT_EQ(error.status, Exit::kBadInput);
    return error.kind;
  }
  return "accepted";
}

TEST(BulletEngine, RejectsBodiesThatCannotBe) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<std::string, std::function<void(RigidBody&)>>> faults = {
      {"id 0", [](RigidBody& b) { b.id = 0; }},
      {"id twice", [](RigidBody& b) { b.id = 1; }},
      {"mass 0", [](RigidBody& b) { b.mass = 0.0; }},
      {"mass nan", [&](RigidBody& b) { b.mass = nan; }},
      {"inertia", [](RigidBody& b) { b.principal_inertia.y() = -1.0; }},
      {"position", [&](RigidBody& b) { b.motion.position.z() = nan; }},
      {"momentum", [&](RigidBody& b) { b.motion.angular_momentum.x() = 1.0 / 0.0; }},
      {"orientation", [](RigidBody& b) { b.motion.orientation.w() = 2.0; }},
      {"no parts", [](RigidBody& b) { b.shape = ConvexShape{}; }},
      {"3 corners", [](RigidBody& b) { std::get<ConvexShape>(b.shape).parts[0].resize(3); }},
      {"flat",
       [](RigidBody& b) {
         for (Vec3& p : std::get<ConvexShape>(b.shape).parts[0]) p.z() = 0.001;
       }},
      {"corner nan", [&](RigidBody& b) { std::get<ConvexShape>(b.shape).parts[0][2].x() = nan; }},
      {"radius", [](RigidBody& b) { b.shape = SphereShape{-1.0}; }},
      {"half size", [](RigidBody& b) { b.shape = BoxShape{Vec3(1, 0, 1)}; }},
      {"moving half space", [](RigidBody& b) { b.shape = HalfSpaceShape{}; }},
  };
  BulletEngine engine;
  engine.add(small_shard(1));
  for (const auto& [name, spoil] : faults) {
    RigidBody body = small_shard(2);
    spoil(body);
    EXPECT_EQ(kind_of([&] { engine.add(body); }), "bad_body") << name;
  }
  EXPECT_EQ(engine.states().size(), 1u);
  engine.add(small_shard(2));  // without a fault it is accepted
}

TEST(BulletEngine, RejectsPredictedStatesThatDoNotMatch) {
  BulletEngine engine;
  engine.add(sphere(1, 0.01, 1.0));
  engine.add(sphere(3, 0.01, 1.0));
  engine.add(half_space(2));
  BodyMotion there, bad;
  there.position = Vec3(1, 0, 0);
  bad.orientation.w() = 1.1;
  const std::vector<std::vector<PredictedState>> faults = {
      {},
      {{1, there}},
      {{3, there}},
      {{1, there}, {2, there}, {3, there}},
      {{3, there}, {1, there}},
      {{1, there}, {3, there}, {3, there}},
      {{1, there}, {4, there}},
      {{1, there}, {3, bad}},
  };
  for (std::size_t i = 0; i < faults.size(); ++i)
    EXPECT_EQ(kind_of([&] { engine.advance(kWindow, faults[i], {}); }), "bad_handback") << i;
  EXPECT_EQ(kind_of([&] { engine.advance(0.0, {{1, there}, {3, there}}, {}); }), "bad_handback");
  EXPECT_EQ(engine.states()[0].motion.position, Vec3::Zero());  // nothing moved
}

TEST(BulletEngine, RejectsContactLawsThatCannotBe) {
  BulletEngine engine;
  EXPECT_EQ(kind_of([&] { engine.set_contact_laws({{0, 0, -0.1, 0.0}}); }), "bad_contact_law");
  EXPECT_EQ(kind_of([&] { engine.set_contact_laws({{0, 0, 0.1, 1.1}}); }), "bad_contact_law");
}

TEST(BulletEngine, IsMadeByName) {
  const EngineInfo info = make_engine("bullet")->info();
  EXPECT_EQ(info.name, "bullet");
  EXPECT_EQ(info.version.substr(0, 2), "3.");
  for (const std::string& name : engine_names()) EXPECT_EQ(make_engine(name)->info().name, name);
  EXPECT_EQ(kind_of([] { make_engine("bulet"); }), "unknown_engine");
}

}  // namespace
}  // namespace sunder::rigid
