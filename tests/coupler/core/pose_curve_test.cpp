// Poses along a smooth path through keys.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "coupler/core/pose_curve.h"

using namespace sunder;

namespace {

constexpr double kStep = 1e-6;  // [s] of differences: their error is its square times the third derivative

Vec3 velocity(const PoseCurve& c, double t) {
  return (c.at(t + kStep).position - c.at(t - kStep).position) / (2.0 * kStep);
}

Vec3 spin(const PoseCurve& c, double t) {
  return rotation_vector(c.at(t + kStep).orientation * c.at(t - kStep).orientation.conjugate()) / (2.0 * kStep);
}

PoseKey key(double time, const Vec3& position, const Vec3& turn) {
  PoseKey k;
  k.time = time, k.position = position, k.turn = turn;
  return k;
}

const std::vector<PoseKey> kKeys = {key(0.0, {0, 0, 0}, {0, 0, 0}), key(0.4, {1, 0.2, 0}, {0.5, 0.1, 0}),
                                    key(1.0, {1.5, 1, 0.3}, {0.7, 0.9, -0.3}), key(1.3, {2, 1.2, 0}, {0.2, 1.4, 0.5})};

TEST(PoseCurve, MeetsItsKeysAndRestsBeyondThem) {
  const PoseCurve c(kKeys);
  for (const PoseKey& k : kKeys) {
    EXPECT_LT((c.at(k.time).position - k.position).norm(), 1e-15);
    EXPECT_LT(c.at(k.time).orientation.angularDistance(rotation_from_vector(k.turn)), 1e-15);
  }
  EXPECT_EQ(c.at(-1.0).position, kKeys.front().position);
  EXPECT_EQ(c.at(9.0).position, kKeys.back().position);
  for (const double t : {0.0, 1.3}) {
    EXPECT_LT(velocity(c, t).norm(), 1e-4);  // half of the difference lies beyond the end
    EXPECT_LT(spin(c, t).norm(), 1e-4);
  }
}

TEST(PoseCurve, HasNoJumpOfVelocityOrSpinInItsKeys) {
  const PoseCurve c(kKeys);
  for (const double t : {0.4, 1.0}) {
    const double h = 2.0 * kStep;
    EXPECT_LT((velocity(c, t - h) - velocity(c, t + h)).norm(), 1e-3) << t;
    EXPECT_LT((spin(c, t - h) - spin(c, t + h)).norm(), 1e-3) << t;
    EXPECT_GT(velocity(c, t).norm(), 0.5);
    EXPECT_GT(spin(c, t).norm(), 0.5);
  }
}

TEST(PoseCurve, TakesVelocityAndSpinOfAKey) {
  std::vector<PoseKey> keys = kKeys;
  keys[2].velocity = Vec3(0.3, -0.2, 1.0), keys[2].spin = Vec3(-0.5, 2.0, 0.4);
  const PoseCurve c(keys);
  EXPECT_LT((velocity(c, 1.0) - *keys[2].velocity).norm(), 1e-4);
  EXPECT_LT((spin(c, 1.0) - *keys[2].spin).norm(), 1e-4);
}

TEST(PoseCurve, OfOneVelocityIsAStraightLine) {
  PoseKey a = key(0, {0, 0, 1}, {0, 0, 0}), b = key(2, {0, 0, -5}, {0, 0, 0});
  a.velocity = b.velocity = Vec3(0, 0, -3), a.spin = b.spin = Vec3::Zero();
  const PoseCurve c({a, b});
  for (const double t : {0.1, 1.0, 1.9}) EXPECT_NEAR(c.at(t).position.z(), 1.0 - 3.0 * t, 1e-14);
}

TEST(PoseCurve, CountsWholeTurnsAboutAnAxisAndTakesTheShorterWayForQuaternions) {
  const double turn = 2.0 * std::numbers::pi;
  const PoseCurve twice({key(0, Vec3::Zero(), {0, 0, 0}), key(1, Vec3::Zero(), {0, 0, 2.0 * turn})});
  EXPECT_LT(twice.at(0.5).orientation.angularDistance(rotation_from_vector({0, 0, turn})), 1e-12);
  EXPECT_NEAR(spin(twice, 0.5).z(), 1.5 * 2.0 * turn, 1e-6);  // the middle of a smooth step
  for (const double t : {0.0, 0.3, 0.9}) {
    const double to = t + 0.1, s = t * t * (3.0 - 2.0 * t), e = to * to * (3.0 - 2.0 * to);
    EXPECT_NEAR(twice.turning(t, to), 2.0 * turn * (e - s), 1e-12);
  }
  EXPECT_EQ(twice.turning(1.0, 2.0), 0.0);
  PoseKey a = key(0, Vec3::Zero(), {0, 0, 3.0}), b = key(1, Vec3::Zero(), {0, 0, -3.0});
  a.counts_turns = b.counts_turns = false;
  EXPECT_LT(PoseCurve({a, b}).at(0.5).orientation.angularDistance(rotation_from_vector({0, 0, 0.5 * turn})), 1e-12);
}

}  // namespace
