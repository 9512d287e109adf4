// Copies of bodies that substeps push: impulses, distances.
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "shell/contact/proxy.h"
#include "shell/solver/forces.h"
#include "tests/coupler/shard.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(Contact, ImpulseObeysCoulombAndOnlyPushes) {
  using shell::contact_impulse;
  const Vec3 n(0, 0, 1);
  const Mat3 two = 0.5 * Mat3::Identity();  // a mass of 2 kg
  EXPECT_EQ(contact_impulse(n, {1, 0, 0.1}, two, 0.5, 0.0), Vec3(Vec3::Zero()));
  const Vec3 sticks = contact_impulse(n, {0.1, 0, -1}, two, 0.5, 0.0);
  EXPECT_NEAR((sticks - Vec3(-0.2, 0, 2)).norm(), 0.0, 1e-15);
  const Vec3 slides = contact_impulse(n, {3, 4, -1}, two, 0.5, 0.0);
  EXPECT_NEAR((slides - Vec3(-0.6, -0.8, 2)).norm(), 0.0, 1e-15);
  EXPECT_NEAR(contact_impulse(n, {0, 0, -1}, two, 0.5, 0.4).z(), 2.8, 1e-15);
}

TEST(Contact, NeverAddsEnergyHoweverRoughAndHoweverTheBodyTurns) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto vector = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  for (int i = 0; i < 20000; ++i) {
    const Vec3 arm = vector(), n = vector().normalized(), v = vector();
    Mat3 k = std::abs(uniform(random)) * Mat3::Identity();  // a point and a body of 1 kg, unequal moments of inertia
    for (int d = 0; d < 3; ++d)
      k.col(d) += Vec3(0.5, 5.0, 50.0).cwiseProduct(arm.cross(Vec3::Unit(d))).cross(arm) + Vec3::Unit(d);
    const Vec3 j = shell::contact_impulse(n, v, k, 5.0 * std::abs(uniform(random)), 0.0);
    EXPECT_GE(n.dot(j), 0.0);
    EXPECT_LE(j.dot(v + 0.5 * (k * j)), 1e-14);  // work of the impulse
    EXPECT_GE(n.dot(v + k * j), -1e-12 * (1.0 + v.norm()));
  }
}

TEST(Proxy, TurnsWithImpulsesLikeARigidBody) {
  shell::Proxy p(shard());
  const Vec3 at(0.2, -0.1, 0.35), j(0.01, -0.02, 0.03);
  const double energy = p.body.kinetic_energy();
  const Vec3 before = p.velocity_at(at);
  p.apply(at, j);
  const Vec3 after = p.velocity_at(at);
  EXPECT_NEAR(p.body.kinetic_energy() - energy, 0.5 * j.dot(before + after), 1e-15);  // work of an impulse
  EXPECT_NEAR((after - before).dot(j.normalized()), j.normalized().dot(p.inverse_mass_at(at) * j), 1e-14);
}

TEST(Proxy, DistanceToAConvexPartIsThatToItsPlanes) {
  RigidBody b = shard();
  b.motion.position.setZero(), b.motion.orientation = Quat::Identity();
  b.shape = ConvexShape{
      {{{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {-1, 1, 1}, {1, 1, 1}}}};
  const shell::Proxy p(b);
  EXPECT_NEAR(p.distance({0.2, 0.3, 0.9}).value, -0.1, 1e-12);
  EXPECT_NEAR((p.distance({0.2, 0.3, 0.9}).normal - Vec3(0, 0, 1)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(p.distance({0, -1.5, 0.2}).value, 0.5, 1e-12);
}

// A plate of two halves: what is pressed into it beside the joint leaves through a face, not into the other half.
TEST(Proxy, DoesNotPushWhatItHoldsThroughAJoint) {
  const auto half = [](double from, double to) {
    std::vector<Vec3> corners;
    for (const double x : {from, to})
      for (const double y : {-1.0, 1.0})
        for (const double z : {-0.1, 0.1}) corners.emplace_back(x, y, z);
    return corners;
  };
  RigidBody b;
  b.shape = ConvexShape{{half(-1.0, 0.0), half(0.0, 1.0)}};
  const Proxy plate(b);
  for (const double x : {-0.02, -1e-9, 0.0, 1e-9, 0.02}) {
    const Proxy::Distance d = plate.distance({x, 0.3, 0.05});
    EXPECT_NEAR(d.value, -0.05, 1e-9) << x;
    EXPECT_LT((d.normal - Vec3::UnitZ()).norm(), 1e-9) << x;
  }
  // with a knob on it: beside the knob's foot a point leaves upwards, within it by the knob's side
  b.shape = ConvexShape{{half(-1.0, 1.0), {}}};
  auto& parts = std::get<ConvexShape>(b.shape).parts;
  for (const double x : {-0.1, 0.1})
    for (const double y : {-0.1, 0.1})
      for (const double z : {0.1, 0.3}) parts[1].emplace_back(x, y, z);
  const Proxy knobbed(b);
  EXPECT_LT((knobbed.distance({0.101, 0.0, 0.099}).normal - Vec3::UnitZ()).norm(), 1e-9);
  const Proxy::Distance foot = knobbed.distance({0.099, 0.0, 0.099});
  EXPECT_LT((foot.normal - Vec3::UnitX()).norm(), 1e-9);
  EXPECT_NEAR(foot.value, -0.002, 1e-5);
  EXPECT_NEAR(plate.distance({0.98, 0.3, 0.05}).normal.x(), 1.0, 1e-9);  // an end is a face
  EXPECT_NEAR(plate.distance({0.01, 0.3, 0.15}).value, 0.05, 1e-9);
}

// Of a prism with few corners and with many, which take another way to its faces.
TEST(Proxy, OfAPrismIsAsFarAsItsFaces) {
  for (const int n : {3, 7, 12, 13, 40, 300}) {
    const double inner = std::cos(std::numbers::pi / n), half = 0.05;  // of a ring of radius 1
    ConvexShape shape;
    shape.parts.emplace_back();
    for (int k = 0; k < n; ++k)
      for (const double z : {-half, half})
        shape.parts[0].emplace_back(std::cos(2.0 * k * std::numbers::pi / n), std::sin(2.0 * k * std::numbers::pi / n),
                                    z);
    RigidBody b;
    b.shape = shape;
    const Proxy prism(b);
    EXPECT_NEAR(prism.distance(Vec3::Zero()).value, -half, 1e-9) << n;
    EXPECT_NEAR(prism.distance(Vec3(0.1, -0.2, 0.15)).value, 0.1, 1e-9) << n;
    for (int k = 0; k < n; ++k) {  // before the middle of each face
      const double angle = (2 * k + 1) * std::numbers::pi / n;
      const Vec3 way(std::cos(angle), std::sin(angle), 0.0);
      const Proxy::Distance d = prism.distance((inner + 0.3) * way);
      EXPECT_NEAR(d.value, 0.3, 1e-9) << n;
      EXPECT_LT((d.normal - way).norm(), 1e-6) << n;
    }
  }
}
