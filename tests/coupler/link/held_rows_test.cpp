#include "coupler/link/held_rows.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

using namespace sunder;
using namespace sunder::link;

namespace {

constexpr double kStep = 7e-6;  // [s]

RigidBody ball(BodyId id, const Vec3& at, double mass = 0.009) {
  RigidBody b;
  b.id = id, b.mass = mass, b.principal_inertia = Vec3::Constant(0.4 * mass * 0.04 * 0.04);
  b.motion.position = at, b.shape = SphereShape{0.04};
  return b;
}

RigidBody floor_body() {
  RigidBody b;
  b.id = 9, b.is_static = true, b.shape = HalfSpaceShape{};
  return b;
}

ContactRow on_floor(BodyId id) { return {id, 9, {0, 0, -0.04}, {0, 0, 0}, Vec3::UnitZ(), 0.0, 0.0, 0.0}; }

}  // namespace

// A ball is pushed down and sideways for a thousand substeps. It neither sinks in nor turns by the contact.
TEST(HeldRows, ABallThatSlidesStaysOnTheFloorAndIsNotTurned) {
  RigidBody b = ball(1, {0, 0, 0.04}), f = floor_body();
  HeldRows rows;
  for (int window = 0; window < 5; ++window) {
    rows.take({on_floor(1)}, {}, {&b, &f});
    for (int k = 0; k < 200; ++k) {
      b.motion.velocity += Vec3(1e-3, 0, -1e-2 * (k % 7));
      rows.solve(kStep);
      b.drift(kStep);
    }
  }
  EXPECT_GT(b.motion.position.x(), 1e-3);
  EXPECT_NEAR(b.motion.position.z(), 0.04, 1e-12);
  EXPECT_LT(b.motion.angular_momentum.norm(), 1e-15);
}

TEST(HeldRows, AGapClosesWithinASubstepWithoutAnOverlap) {
  RigidBody b = ball(1, {0, 0, 0.04 + 1e-5}), f = floor_body();
  b.motion.velocity = {0, 0, -10};
  HeldRows rows;
  rows.take({on_floor(1)}, {}, {&b, &f});
  EXPECT_GT(rows.solve(kStep), 0.0) << "an inelastic stop takes energy";
  EXPECT_NEAR(b.motion.velocity.z(), -1e-5 / kStep, 1e-9);
  b.drift(kStep);
  EXPECT_NEAR(b.motion.position.z(), 0.04, 1e-12);
}

TEST(HeldRows, AContactOnlyPushesAndBouncesWithItsRestitution) {
  RigidBody b = ball(1, {0, 0, 0.04}), f = floor_body();
  HeldRows rows;
  ContactRow row = on_floor(1);
  row.restitution = 0.5;
  rows.take({row}, {}, {&b, &f});
  b.motion.velocity = {0, 0, -2};
  rows.solve(kStep);
  EXPECT_NEAR(b.motion.velocity.z(), 1.0, 1e-12);
  b.drift(kStep);
  rows.solve(kStep);
  EXPECT_NEAR(b.motion.velocity.z(), 1.0, 1e-12) << "what leaves is not held back";
}

TEST(HeldRows, TwoLinkedBodiesKeepTheirMomenta) {
  for (const auto kind : {Joint::Kind::kBall, Joint::Kind::kHinge, Joint::Kind::kSlider, Joint::Kind::kFixed}) {
    RigidBody a = ball(1, {0, 0, 0}), b = ball(2, {0.1, 0, 0}, 0.02);
    a.motion.velocity = {0.3, 1, 0}, b.motion.velocity = {-0.2, 0, 0.5}, a.motion.angular_momentum = {1e-5, 2e-5, 3e-5};
    Joint joint;
    joint.id = 1, joint.kind = kind, joint.first = 1, joint.second = 2;
    joint.first_frame.position = {0.05, 0, 0}, joint.second_frame.position = {-0.05, 0, 0};
    const auto momentum = [&] { return Vec3(a.mass * a.motion.velocity + b.mass * b.motion.velocity); };
    const auto angular = [&] {
      Vec3 sum = Vec3::Zero();
      for (const RigidBody* q : {&a, &b})
        sum += q->motion.angular_momentum + q->mass * q->motion.position.cross(q->motion.velocity);
      return sum;
    };
    const Vec3 p = momentum(), l = angular();
    HeldRows rows;
    rows.take({}, {joint}, {&a, &b});
    for (int k = 0; k < 2000; ++k) rows.solve(kStep), a.drift(kStep), b.drift(kStep);
    EXPECT_LT((momentum() - p).norm(), 1e-14);
    EXPECT_LT((angular() - l).norm(), 1e-14);
    if (kind == Joint::Kind::kSlider) continue;
    const Vec3 gap = a.motion.position + a.motion.orientation * joint.first_frame.position - b.motion.position -
                     b.motion.orientation * joint.second_frame.position;
    EXPECT_LT(gap.norm(), 1e-9) << static_cast<int>(kind);  // one Newton step in each substep
  }
}

// Half a period of a pendulum that starts horizontally.
TEST(HeldRows, AHingedRodKeepsItsEnergyAndItsAxis) {
  RigidBody b = ball(1, {0.1, 0, 0});
  Joint joint;
  joint.id = 1, joint.kind = Joint::Kind::kHinge, joint.first = 1;
  const Quat along_y(Eigen::AngleAxisd(-0.5 * std::numbers::pi, Vec3::UnitX()));  // from z
  joint.first_frame = {{-0.1, 0, 0}, along_y}, joint.second_frame = {Vec3::Zero(), along_y};
  HeldRows rows;
  rows.take({}, {joint}, {&b});
  double worst = 0.0;
  for (int k = 0; k < 40000; ++k) {
    b.motion.velocity.z() -= 0.5 * kStep * 9.81;
    if (k % 100 == 0) worst = std::max(worst, std::abs(b.kinetic_energy() + b.mass * 9.81 * b.motion.position.z()));
    b.motion.velocity.z() -= 0.5 * kStep * 9.81;
    rows.solve(kStep), b.drift(kStep);
  }
  EXPECT_LT(worst, 1e-3 * b.mass * 9.81 * 0.1);
  EXPECT_LT((b.motion.orientation * Vec3::UnitY() - Vec3::UnitY()).norm(), 1e-9);
  EXPECT_NEAR(b.motion.position.norm(), 0.1, 1e-8);
}
