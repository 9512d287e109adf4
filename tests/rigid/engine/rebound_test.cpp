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
  EXPECT_TRUE(of({strike(2, 1), beside})[0]);  // the sweep of its way back looks at that one
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

class EveryRebound : public EveryEngine {};
INSTANTIATE_TEST_SUITE_P(Of, EveryRebound, ::testing::Values(kBullet, kOde), name_of);

// 20 bounces of 0.2 s each in 4000 windows of 1 ms, no whole number of which is a bounce. The ball's flight is exact,
// as a run's is. A rebound at the window's end loses up to 2 mm of place, and a share of 1e-2 of the energy.
TEST_P(EveryRebound, ABallBouncesAtTheRightTimesAndKeepsItsEnergy) {
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
  // Residuals of the solver, relative, in 20 bounces. Each changes the period of all that follow: a ball of 1 m/s is
  // off by up to 20 * 20 / 2 of them times 0.2 m. The rest is the margin.
  EXPECT_LT(most, 1e3 * GetParam().solved);
  EXPECT_LT(lost, 1e3 * GetParam().solved);
}

// A window of 1 ms. The ball of 0.05 m flies 2 mm in it, and what it may overlap is what engines leave.
constexpr double kBall = 0.05, kSpeed = 2.0, kLeft = 5e-6;

/// A wall whose face looks along `normal` through `place`.
RigidBody wall(BodyId id, const Vec3& normal, const Vec3& place) {
  RigidBody body = box(id, Vec3(0.2, 0.2, 0.01), 1.0);
  body.is_static = true, body.mass = 0.0, body.principal_inertia = Vec3::Zero();
  body.motion.orientation = Quat::FromTwoVectors(Vec3::UnitZ(), normal);
  body.motion.position = place - 0.01 * normal;
  return body;
}

/// One window of free flight under `pull` along x [m/s^2]. Returns what the engine makes of the ball 2.
BodyMotion window(Engine& engine, RigidBody& ball, double pull = 0.0) {
  RigidBody flown = ball;
  flown.drift(kH);
  flown.motion.position.x() += 0.5 * pull * kH * kH, flown.motion.velocity.x() += pull * kH;
  engine.advance(kH, {{2, flown.motion}}, {});
  return ball.motion = engine.states()[0].motion;
}

// The walls leave the ball from 10 um to 3 mm, less and more than its way in a window, without and with gravity.
TEST_P(EveryRebound, ABallBetweenTwoWallsIsInNeitherAndKeepsItsEnergy) {
  for (const double room : {1e-5, 0.37e-3, 0.9e-3, 1.7e-3, 2.1e-3, 3e-3})
    for (const double aside : {0.0, 1.3})
      for (const double pull : {0.0, -kGravity}) {
        const auto engine = make();
        engine->set_contact_laws({{0, 0, 0.0, 1.0}});
        RigidBody ball = sphere(2, kBall, 0.3);
        ball.motion.velocity = Vec3(kSpeed, aside, 0.0);
        ball.motion.position = Vec3(kBall + 0.3 * room, 0, 0);
        engine->add(wall(1, Vec3::UnitX(), Vec3::Zero()));
        engine->add(ball);
        engine->add(wall(3, -Vec3::UnitX(), Vec3(2.0 * kBall + room, 0, 0)));
        const auto energy = [&] { return ball.motion.velocity.squaredNorm() - 2.0 * pull * ball.motion.position.x(); };
        const double start = energy();
        for (int n = 0; n < 60; ++n) {
          const BodyMotion m = window(*engine, ball, pull);
          const auto where = fmt::format("room {} m, {} m/s aside, pull {} m/s^2, window {}", room, aside, pull, n);
          EXPECT_GT(m.position.x(), kBall - kLeft) << where;
          EXPECT_LT(m.position.x(), kBall + room + kLeft) << where;
          EXPECT_NEAR(energy() / start, 1.0, 1e3 * GetParam().solved) << where;
          EXPECT_NEAR(m.position.y(), aside * kH * (n + 1), 1e-9) << where;
        }
      }
}

// What stands behind the ball leaves it 1.3 mm to the wall before it, of 1.6 mm that it would fly back.
TEST_P(EveryRebound, TheWayBackIsSweptAgainstEveryShape) {
  const Vec3 behind(1.3e-3 + kBall, 0, 0);
  RigidBody post = sphere(3, 0.02, 1.0), shard = plate(3, {rectangle(-0.05, -0.05, 0.05, 0.05)}, 0.01);
  post.motion.position = behind + Vec3(0.02, 0, 0);
  shard.motion.orientation = Quat::FromTwoVectors(Vec3::UnitZ(), Vec3::UnitX());
  shard.motion.position = behind + Vec3(0.005, 0, 0);
  RigidBody moving = post;
  for (RigidBody* b : {&post, &shard}) b->is_static = true, b->mass = 0.0, b->principal_inertia = Vec3::Zero();
  RigidBody ground = half_space(3);
  ground.motion.orientation = Quat::FromTwoVectors(Vec3::UnitZ(), -Vec3::UnitX());
  ground.motion.position = behind;
  for (const RigidBody& other : {post, shard, ground, moving}) {
    const auto engine = make();
    engine->set_contact_laws({{0, 0, 0.0, 1.0}});
    RigidBody ball = sphere(2, kBall, 0.3);
    ball.motion.velocity = Vec3(-kSpeed, 0, 0), ball.motion.position = Vec3(0.4e-3, 0, 0);
    engine->add(wall(1, Vec3::UnitX(), Vec3(-kBall, 0, 0)));
    engine->add(ball), engine->add(other);
    RigidBody flown = ball;
    flown.drift(kH);
    std::vector<PredictedState> predicted{{2, flown.motion}};
    if (!other.is_static) predicted.push_back({3, other.motion});
    engine->advance(kH, predicted, {});
    const BodyMotion m = engine->states()[0].motion;
    EXPECT_GT(m.position.x(), -kLeft);
    EXPECT_LT(m.position.x(), behind.x() - kBall + kLeft) << other.name;
    if (other.is_static) {
      EXPECT_NEAR(m.position.x(), behind.x() - kBall, kLeft) << other.name;
    }
    EXPECT_NEAR(m.velocity.x(), kSpeed, 1e3 * GetParam().solved) << other.name;
  }
}

// The shell throws the ball against a wall that it touches, and away from one: both within the window.
TEST_P(EveryRebound, ABallThatAShellThrowsStaysOutOfTheWallThatItTouches) {
  for (const bool solved : {false, true}) {
    for (const Vec3& thrown : {Vec3(-1.5, 0, 2), Vec3(1.5, 0, 2), Vec3(0, 0, 2)}) {
      const auto engine = make();
      engine->set_contact_laws({{0, 0, 0.3, 1.0}});
      RigidBody ball = sphere(2, kBall, 0.3);
      ball.motion.position = Vec3(kBall, 0, 0), ball.motion.velocity = Vec3(0, 0, -kSpeed);
      engine->add(wall(1, Vec3::UnitX(), Vec3::Zero()));
      engine->add(ball);
      BodyMotion given = ball.motion;  // half the window down, half of it up
      given.velocity = thrown, given.position += 0.5 * kH * (ball.motion.velocity + thrown);
      engine->advance(kH, {{2, given}}, solved ? std::vector<BodyId>{2} : std::vector<BodyId>{});
      const BodyMotion m = engine->states()[0].motion;
      if (solved || thrown.x() >= 0.0) {
        EXPECT_EQ(bits(m), bits(given));
        continue;
      }
      EXPECT_GT(m.position.x(), kBall - kLeft);
      EXPECT_GE(m.velocity.x(), 0.0);
      EXPECT_LE(m.velocity.norm(), given.velocity.norm() * (1.0 + GetParam().solved));
    }
  }
}

// The shell has solved the contacts of the ball 4, which lies behind the ball 2: it is not forgotten.
TEST_P(EveryRebound, AReboundDoesNotForgetWhatTheShellHasSolved) {
  const auto engine = make();
  engine->set_contact_laws({{0, 0, 0.0, 1.0}});
  RigidBody ball = sphere(2, kBall, 0.3), solved = sphere(4, kBall, 0.3);
  ball.motion.velocity = Vec3(-kSpeed, 0, 0), ball.motion.position = Vec3(0.4e-3, 0, 0);
  solved.motion.position = Vec3(2.0 * kBall + 0.5e-3, 0, 0);
  engine->add(wall(1, Vec3::UnitX(), Vec3(-kBall, 0, 0)));
  engine->add(ball), engine->add(solved);
  RigidBody flown = ball;
  flown.drift(kH);
  engine->advance(kH, {{2, flown.motion}, {4, solved.motion}}, {4});
  const auto states = engine->states();
  EXPECT_EQ(bits(states[1].motion), bits(solved.motion));
  EXPECT_LT(states[0].motion.position.x(), 0.5e-3 + kLeft);
  EXPECT_NEAR(states[0].motion.velocity.x(), kSpeed, 1e3 * GetParam().solved);
}

// An oblique impact of a spinning ball: the tangential impulse is mu of the normal one, and acts at the touch. Without
// friction the spin stays.
TEST_P(EveryRebound, AReboundKeepsSpinAndCoulombsLaw) {
  for (const double friction : {0.0, 0.2}) {
    const auto engine = make();
    engine->set_contact_laws({{0, 0, friction, 0.8}});
    RigidBody ball = sphere(2, kBall, 0.3);
    const Vec3 spin(3, -40, -7);
    ball.motion.position = Vec3(0, 0, kBall + 0.6e-3), ball.motion.velocity = Vec3(4, 0, -kSpeed);
    ball.motion.angular_momentum = ball.apply_inertia(spin);
    engine->add(half_space(1)), engine->add(ball);
    const RigidBody before = ball;
    const BodyMotion m = window(*engine, ball);
    const double near = 1e3 * GetParam().solved, touch = 0.3e-3, rest = kH - touch, normal = 1.8 * kSpeed;
    // slip of the touching point: v - w x r, along x but for the spin about x
    const Vec3 slip = before.motion.velocity - Vec3(0, 0, -kSpeed) + spin.cross(Vec3(0, 0, -kBall));
    const Vec3 drag = -friction * normal * slip.normalized();
    EXPECT_NEAR((m.velocity - before.motion.velocity - drag - Vec3(0, 0, normal)).norm(), 0.0, near);
    const Vec3 torque = Vec3(0, 0, -kBall).cross(0.3 * drag);
    EXPECT_NEAR((ball.angular_velocity() - spin - before.apply_inverse_inertia(torque)).norm(), 0.0, near / kBall);
    const Vec3 place = before.motion.position + kH * before.motion.velocity + rest * (drag + Vec3(0, 0, normal));
    EXPECT_NEAR((m.position - place).norm(), 0.0, near * kH + 1e-12);
    const Quat turned = rotation_from_vector(rest * (ball.angular_velocity() - spin)) * rotation_from_vector(kH * spin);
    // the two turns are about other axes: their order matters by |w| |dw| H^2 / 2
    EXPECT_LT(rotation_vector(m.orientation * turned.conjugate()).norm(),
              0.5 * spin.norm() * (ball.angular_velocity() - spin).norm() * kH * kH + 1e-9);
  }
}

/// Sum of m x v + L of two bodies.
Vec3 angular(const RigidBody& a, const RigidBody& b) {
  return a.mass * a.motion.position.cross(a.motion.velocity) + a.motion.angular_momentum +
         b.mass * b.motion.position.cross(b.motion.velocity) + b.motion.angular_momentum;
}

// Two balls that meet off their centres in free fall. They touch where |d + v t| is the sum of their radii, exchange
// (1 + e) of the closing speed along the line of centres by their reduced mass, and fly on for the rest of the window.
TEST_P(EveryRebound, TwoMovingBallsPartFromTheirTouch) {
  for (const double restitution : {0.5, 1.0})
    for (const double pull : {0.0, -kGravity}) {
      const auto engine = make();
      engine->set_contact_laws({{0, 0, 0.0, restitution}});
      RigidBody a = sphere(2, kBall, 0.3), b = sphere(4, 0.03, 0.1);
      a.motion.velocity = Vec3(1.5, 0.4, 0.1), b.motion.velocity = Vec3(-0.7, 0.0, -0.6);
      b.motion.position = Vec3(0.065, 0.04, 0.0253);
      a.motion.angular_momentum = a.apply_inertia(Vec3(3, -4, 5));
      engine->add(a), engine->add(b);
      const auto fly = [&](RigidBody body, double h) {
        body.drift(h);
        body.motion.position.z() += 0.5 * pull * h * h, body.motion.velocity.z() += pull * h;
        return body;
      };
      const Vec3 d = b.motion.position - a.motion.position, v = b.motion.velocity - a.motion.velocity;
      const double vv = v.squaredNorm(), dv = d.dot(v), over = d.squaredNorm() - 0.08 * 0.08;
      const double touch = (-dv - std::sqrt(dv * dv - vv * over)) / vv;
      ASSERT_GT(touch, 0.1 * kH);
      ASSERT_LT(touch, 0.9 * kH);
      RigidBody one = fly(a, touch), other = fly(b, touch);
      const Vec3 n = (other.motion.position - one.motion.position).normalized();
      const double impulse = (1.0 + restitution) * -v.dot(n) / (1.0 / a.mass + 1.0 / b.mass);
      one.motion.velocity -= impulse / a.mass * n, other.motion.velocity += impulse / b.mass * n;
      one = fly(one, kH - touch), other = fly(other, kH - touch);

      engine->advance(kH, {{2, fly(a, kH).motion}, {4, fly(b, kH).motion}}, {});
      const auto states = engine->states();
      const auto where = fmt::format("restitution {}, pull {}", restitution, pull);
      const double near = 1e3 * GetParam().solved;
      for (const auto& [is, was] :
           {std::pair(states[0].motion, one.motion), std::pair(states[1].motion, other.motion)}) {
        EXPECT_NEAR((is.velocity - was.velocity).norm(), 0.0, near) << where;
        EXPECT_NEAR((is.position - was.position).norm(), 0.0, near * kH + 1e-12) << where;
        EXPECT_NEAR((is.angular_momentum - was.angular_momentum).norm(), 0.0, near * 1e-3) << where;
        EXPECT_NEAR(is.orientation.angularDistance(was.orientation), 0.0, 1e-7) << where;
      }
    }
}

// Boxes that tumble keep their momenta, and without friction elastic ones keep their energy.
TEST_P(EveryRebound, TwoMovingBoxesKeepTheirMomenta) {
  for (const double friction : {0.0, 0.4}) {
    const auto engine = make();
    engine->set_contact_laws({{0, 0, friction, 1.0}});
    RigidBody a = box(2, Vec3(0.05, 0.03, 0.02), 0.3), b = box(4, Vec3(0.04, 0.04, 0.06), 0.9);
    a.motion.velocity = Vec3(1.5, 0.3, 0.1), b.motion.velocity = Vec3(-0.7, 0.0, 0.2);
    a.motion.orientation = rotation_from_vector(Vec3(0.3, 0.5, 0.2));
    b.motion.position = Vec3(0.1008, 0.02, 0.01);
    a.motion.angular_momentum = a.apply_inertia(Vec3(3, -4, 5));
    engine->add(a), engine->add(b);
    const Vec3 before = angular(a, b), linear = a.mass * a.motion.velocity + b.mass * b.motion.velocity;
    const double energy = a.kinetic_energy() + b.kinetic_energy();
    double bounced = 0.0;
    for (int n = 0; n < 20; ++n) {
      RigidBody one = a, other = b;
      one.drift(kH), other.drift(kH);
      engine->advance(kH, {{2, one.motion}, {4, other.motion}}, {});
      const Vec3 was = a.motion.velocity;
      a.motion = engine->states()[0].motion, b.motion = engine->states()[1].motion;
      bounced = std::max(bounced, (a.motion.velocity - was).norm());
    }
    EXPECT_GT(bounced, 0.5);
    EXPECT_NEAR((angular(a, b) - before).norm(), 0.0, 1e-12);
    EXPECT_NEAR((a.mass * a.motion.velocity + b.mass * b.motion.velocity - linear).norm(), 0.0, 1e-12);
    if (friction == 0.0) {  // Newton's law of restitution beside Coulomb's may create energy (Kane and Levinson 1985)
      EXPECT_NEAR((a.kinetic_energy() + b.kinetic_energy()) / energy, 1.0, 1e3 * GetParam().solved);
    }
  }
}

// What stands in the way of one of them is not entered.
TEST_P(EveryRebound, TwoMovingBallsDoNotPartIntoAThirdBody) {
  for (const bool moves : {false, true}) {
    const auto engine = make();
    engine->set_contact_laws({{0, 0, 0.0, 1.0}});
    RigidBody a = sphere(2, kBall, 0.3), b = sphere(4, kBall, 0.3),
              other = wall(5, -Vec3::UnitX(), {kBall + 2e-4, 0, 0});
    a.motion.velocity = Vec3(-0.5, 0, 0), b.motion.velocity = Vec3(1.0, 0, 0);
    b.motion.position = Vec3(-2.0 * kBall - 0.3e-3, 0, 0);
    if (moves) other = sphere(5, kBall, 0.3), other.motion.position = Vec3(2.0 * kBall + 2e-4, 0, 0);
    engine->add(a), engine->add(b), engine->add(other);
    for (int n = 0; n < 10; ++n) {
      std::vector<PredictedState> predicted;
      for (RigidBody* body : {&a, &b, &other}) {
        if (body->is_static) continue;
        RigidBody flown = *body;
        flown.drift(kH);
        predicted.push_back({body->id, flown.motion});
      }
      engine->advance(kH, predicted, {});
      const auto states = engine->states();
      a.motion = states[0].motion, b.motion = states[1].motion;
      if (moves) other.motion = states[2].motion;
      EXPECT_LT(a.motion.position.x(), (moves ? other.motion.position.x() - 2.0 * kBall : 2e-4) + 2.0 * kLeft) << n;
      EXPECT_GT(a.motion.position.x() - b.motion.position.x(), 2.0 * kBall - 2.0 * kLeft) << n;
    }
  }
}

}  // namespace
}  // namespace sunder::rigid
