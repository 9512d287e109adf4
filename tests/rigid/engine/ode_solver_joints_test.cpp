// Joints and exported rows of the ODE adapter.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "coupler/core/error.h"
#include "rigid/engine/ode_solver.h"
#include "tests/rigid/shards.h"

namespace sunder::rigid {
namespace {

using namespace testing;  // NOLINT: the helpers of this folder

Joint link(Joint::Kind kind, BodyId first, BodyId second, const Vec3& first_at, const Vec3& second_at) {
  Joint j;
  j.id = 1, j.name = "link", j.kind = kind, j.first = first, j.second = second;
  j.first_frame.position = first_at, j.second_frame.position = second_at;
  return j;
}

/// Turns the axis of both frames from z to y.
Joint along_y(Joint j) {
  j.first_frame.orientation = j.second_frame.orientation = rotation_from_vector(Vec3(-EIGEN_PI / 2.0, 0, 0));
  return j;
}

Vec3 anchor(const RigidBody& b, const Vec3& local) { return b.motion.position + b.motion.orientation * local; }

double angle_between(const Quat& a, const Quat& b) { return rotation_vector(a * b.conjugate()).norm(); }

TEST(OdeJoints, PendulumKeepsItsEnergyOverTenThousandWindows) {
  for (Joint::Kind kind : {Joint::Kind::kBall, Joint::Kind::kHinge}) {
    OdeEngine engine;
    Caller caller(engine, 1e-3, kGravity);
    RigidBody rod = box(1, Vec3(0.1, 0.01, 0.02), 0.5);
    caller.add(rod);  // held at its left end, released horizontally
    engine.add_joint(along_y(link(kind, 1, 0, Vec3(-0.1, 0, 0), Vec3(-0.1, 0, 0))));
    const double swing = rod.mass * kGravity * 0.1;  // [J] from horizontal to the bottom
    const double before = caller.energy();
    double low = 1e300, high = -1e300, strain = 0.0, deepest = 0.0;
    for (int i = 0; i < 10000; ++i) {
      caller.window();
      low = std::min(low, caller.energy());
      high = std::max(high, caller.energy());
      strain = std::max(strain, (anchor(caller.body(1), Vec3(-0.1, 0, 0)) - Vec3(-0.1, 0, 0)).norm());
      deepest = std::min(deepest, caller.body(1).motion.position.z());
    }
    EXPECT_NEAR(deepest, -0.1, 1e-4);  // it swings
    EXPECT_GT(low, before - 0.01 * swing);
    EXPECT_LT(high, before + 0.01 * swing);
    EXPECT_LT(strain, 1e-4);  // (w H)^2 L / 2 is 7 um at 12 rad/s; on a ball joint it also turns about its length
  }
}

TEST(OdeJoints, PendulumSwingsWithItsPeriod) {
  OdeEngine engine;
  Caller caller(engine, 1e-3, kGravity);
  RigidBody bob = sphere(1, 0.01, 0.2), arm = half_space(2);
  const double tilt = 0.05;
  bob.motion.position = Vec3(0.5 * std::sin(tilt), 0, 1.0 - 0.5 * std::cos(tilt));
  bob.motion.orientation = rotation_from_vector(Vec3(0, -tilt, 0));
  caller.add(bob);
  engine.add_joint(along_y(link(Joint::Kind::kHinge, 1, 0, Vec3(0, 0, 0.5), Vec3(0, 0, 1.0))));
  std::vector<double> crossings;
  for (int i = 0; i < 10000; ++i) {
    const double x = caller.body(1).motion.position.x();
    caller.window();
    const double y = caller.body(1).motion.position.x();
    if (x > 0.0 && y <= 0.0) crossings.push_back(1e-3 * (i + x / (x - y)));
  }
  const double period = 2.0 * EIGEN_PI * std::sqrt((0.25 + 0.4 * 1e-4) / (kGravity * 0.5)) * (1.0 + tilt * tilt / 16.0);
  ASSERT_GE(crossings.size(), 6u);
  EXPECT_NEAR((crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1), period,
              1e-3 * period);
}

TEST(OdeJoints, DoublePendulumKeepsItsEnergy) {
  OdeEngine engine;
  Caller caller(engine, 0.25e-3, kGravity);
  RigidBody upper = box(1, Vec3(0.1, 0.01, 0.02), 0.5), lower = box(2, Vec3(0.1, 0.01, 0.02), 0.3);
  lower.motion.position = Vec3(0.2, 0, 0);
  caller.add(upper);
  caller.add(lower);
  engine.add_joint(along_y(link(Joint::Kind::kHinge, 1, 0, Vec3(-0.1, 0, 0), Vec3(-0.1, 0, 0))));
  Joint knee = link(Joint::Kind::kBall, 1, 2, Vec3(0.1, 0, 0), Vec3(-0.1, 0, 0));
  knee.id = 2;
  engine.add_joint(knee);
  const double before = caller.energy(), swing = kGravity * (0.5 * 0.1 + 0.3 * 0.3);
  double worst = 0.0, strain = 0.0;
  for (int i = 0; i < 10000; ++i) {
    caller.window();
    worst = std::max(worst, std::abs(caller.energy() - before));
    strain =
        std::max(strain, (anchor(caller.body(1), Vec3(0.1, 0, 0)) - anchor(caller.body(2), Vec3(-0.1, 0, 0))).norm());
  }
  EXPECT_LT(worst, 2e-3 * swing);
  EXPECT_LT(strain, 5e-5);
}

/// Two boxes linked along x at the origin, with velocities apart and spins: their motion after the joint has acted.
struct Linked {
  explicit Linked(Joint::Kind kind) : caller(engine, 0.25e-3, 0.0) {
    RigidBody a = box(1, Vec3(0.05, 0.02, 0.03), 0.4), b = box(2, Vec3(0.05, 0.03, 0.02), 0.7);
    a.motion.position = Vec3(-0.05, 0, 0);
    b.motion.position = Vec3(0.05, 0, 0);
    a.motion.velocity = Vec3(0.1, 0.2, 0.5);
    b.motion.velocity = Vec3(-0.1, 0.1, -0.3);
    a.motion.angular_momentum = a.apply_inertia(Vec3(5, 2, -1));
    b.motion.angular_momentum = b.apply_inertia(Vec3(-3, 24, 2));
    caller.add(a);
    caller.add(b);
    engine.add_joint(along_y(link(kind, 1, 2, Vec3(0.05, 0, 0), Vec3(-0.05, 0, 0))));
  }
  Vec3 momentum() const { return 0.4 * caller.body(1).motion.velocity + 0.7 * caller.body(2).motion.velocity; }
  Vec3 spin_momentum() const {
    Vec3 sum = Vec3::Zero();
    for (const auto& [id, b] : caller.bodies())
      sum += b.motion.angular_momentum + b.mass * b.motion.position.cross(b.motion.velocity);
    return sum;
  }
  OdeEngine engine;
  Caller caller;
};

TEST(OdeJoints, EachKindHoldsWhatItShouldAndNothingElse) {
  for (Joint::Kind kind : {Joint::Kind::kBall, Joint::Kind::kHinge, Joint::Kind::kSlider, Joint::Kind::kFixed}) {
    Linked l(kind);
    const Vec3 p = l.momentum(), s = l.spin_momentum();
    l.caller.window();
    const double energy = l.caller.kinetic_energy();
    double apart = 0.0, off_axis = 0.0, turn = 0.0, slid = 0.0, side = 0.0;
    for (int i = 0; i < 2000; ++i) {
      l.caller.window();
      const RigidBody &a = l.caller.body(1), &b = l.caller.body(2);
      const Vec3 gap = a.motion.orientation.conjugate() * (anchor(b, Vec3(-0.05, 0, 0)) - anchor(a, Vec3(0.05, 0, 0)));
      apart = std::max(apart, gap.norm());
      slid = std::max(slid, std::abs(gap.y()));
      side = std::max(side, std::hypot(gap.x(), gap.z()));
      off_axis =
          std::max(off_axis, (a.motion.orientation * Vec3::UnitY()).cross(b.motion.orientation * Vec3::UnitY()).norm());
      turn = std::max(turn, angle_between(a.motion.orientation, b.motion.orientation));
    }
    const int k = static_cast<int>(kind);
    const bool slider = kind == Joint::Kind::kSlider, fixed = kind == Joint::Kind::kFixed;
    EXPECT_LT((l.momentum() - p).norm(), 1e-12) << k;
    EXPECT_LT((l.spin_momentum() - s).norm(), 0.02 * s.norm()) << k;  // O(H), as contacts
    EXPECT_LT(slider ? side : apart, 5e-6) << k;
    if (slider) {
      EXPECT_GT(slid, 0.02);
    }
    if (kind != Joint::Kind::kBall) {
      EXPECT_LT(off_axis, 1e-4) << k;
    }
    if (kind == Joint::Kind::kBall) {
      EXPECT_GT(off_axis, 0.5);
    }
    if (slider || fixed) {
      EXPECT_LT(turn, 1e-4) << k;
    }
    if (kind == Joint::Kind::kHinge) {
      EXPECT_GT(turn, 0.5);
    }
    EXPECT_NEAR(l.caller.kinetic_energy(), energy, 1e-3 * energy) << k;
  }
}

TEST(OdeJoints, AStaticBodyOnEitherSideHoldsAsTheWorldDoes) {
  std::vector<Vec3> ends;
  for (int side = 0; side < 3; ++side) {
    OdeEngine engine;
    Caller caller(engine, 1e-3, kGravity);
    caller.add(box(1, Vec3(0.1, 0.01, 0.02), 0.5));
    RigidBody post = box(2, Vec3(0.01, 0.01, 0.01), 1.0);
    post.is_static = true;
    post.motion.position = Vec3(-0.3, 0.1, 0.2);
    post.motion.orientation = rotation_from_vector(Vec3(0.3, -0.2, 1.0));
    caller.add(post);
    Joint j = along_y(link(Joint::Kind::kHinge, 1, 0, Vec3(-0.1, 0, 0), Vec3(-0.1, 0, 0)));
    if (side > 0) {
      j.second = 2;
      const Quat back = post.motion.orientation.conjugate();
      j.second_frame = {back * (Vec3(-0.1, 0, 0) - post.motion.position), back * j.second_frame.orientation};
    }
    if (side > 1) std::swap(j.first, j.second), std::swap(j.first_frame, j.second_frame);
    engine.add_joint(j);
    caller.run(0.3);
    ends.push_back(caller.body(1).motion.position);
  }
  EXPECT_GT((ends[0] - Vec3::Zero()).norm(), 0.05);
  EXPECT_LT((ends[1] - ends[0]).norm(), 1e-9);
  EXPECT_LT((ends[2] - ends[0]).norm(), 1e-9);
}

TEST(OdeJoints, JointsAndContactsOfSolvedBodiesAreLeftOut) {
  OdeEngine engine;
  RigidBody ball = sphere(1, 0.01, 0.1), other = sphere(2, 0.01, 0.1);
  ball.motion.position = Vec3(0, 0, 0.01);
  other.motion.position = Vec3(0.1, 0, 0.01);
  engine.add(ball);
  engine.add(other);
  engine.add(half_space(3));
  engine.add_joint(link(Joint::Kind::kBall, 1, 2, Vec3(0.05, 0, 0), Vec3(-0.05, 0, 0)));
  BodyMotion down = ball.motion, aside = other.motion;
  down.position.z() -= 0.005;
  down.velocity.z() = -5.0;
  aside.position.z() -= 0.002;
  aside.velocity.z() = -2.0;
  engine.advance(1e-3, {{1, down}, {2, aside}}, {1});
  EXPECT_EQ(engine.states()[0].motion.position, down.position);     // neither floor nor joint
  EXPECT_NEAR(engine.states()[1].motion.position.z(), 0.01, 1e-9);  // the floor holds the other one
  EXPECT_EQ(engine.states()[1].motion.position.x(), 0.1);           // the joint does not
}

TEST(OdeRows, AreTheContactsThatMayActAndMoveNothing) {
  OdeEngine engine;
  engine.set_contact_laws({{0, 4, 0.2, 0.3}});
  RigidBody plate_ = plate(1, {rectangle(-0.05, -0.04, 0.05, 0.04)}, 4e-3), floor = half_space(2);
  plate_.motion.position.z() = 2.5e-3 + 4e-3;
  floor.contact_group = 4;
  RigidBody far = sphere(3, 0.01, 0.1);
  far.motion.position = Vec3(1, 0, 0.0101);
  engine.add(plate_);
  engine.add(floor);
  engine.add(far);
  BodyMotion down = plate_.motion;
  down.position.z() -= 4e-3;
  const std::vector<PredictedState> motions = {{1, down}, {3, far.motion}};
  const std::string caches = engine.save();
  const auto rows = engine.rows(1e-3, motions, {1});
  ASSERT_EQ(rows.size(), 4u);  // its lower corners; the upper ones are 8.5 mm above the floor
  for (const ContactRow& row : rows) {
    EXPECT_EQ(row.first, 1u);
    EXPECT_EQ(row.second, 2u);
    EXPECT_LT((row.normal - Vec3::UnitZ()).norm(), 1e-12);
    EXPECT_EQ(row.friction, 0.2);
    EXPECT_EQ(row.restitution, 0.3);
    EXPECT_EQ(row.allowance, 0.0);
    EXPECT_NEAR(anchor(plate_, row.first_point).z(), 4.5e-3, 1e-12);
    EXPECT_NEAR(row.second_point.z(), 0.0, 1e-12);
    EXPECT_LT((anchor(plate_, row.first_point) - row.second_point).head<2>().norm(), 1e-12);
  }
  EXPECT_EQ(engine.rows(1e-3, motions, {2}).size(), 5u);  // the floor's: with the ball that lies 0.1 mm above it
  EXPECT_EQ(engine.rows(1e-3, {{1, plate_.motion}, {3, far.motion}}, {1}).size(), 0u);
  EXPECT_EQ(engine.states()[0].motion.position, plate_.motion.position);
  EXPECT_EQ(engine.save(), caches);
}

}  // namespace
}  // namespace sunder::rigid
