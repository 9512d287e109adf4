// Bodies whose motion and shape are prescribed: places, velocities, and what impulses do to them.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "coupler/scene/mesh.h"
#include "shell/contact/proxy.h"
#include "tests/coupler/arch.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

std::shared_ptr<DrivenMotion> swing() {
  PoseKey a, b;
  b.time = 1.0, b.position = {0.4, 0, 0.2}, b.turn = {0, 1.2, 0};
  auto motion = std::make_shared<DrivenMotion>();
  motion->path = PoseCurve({a, b}), motion->own.position = {0, 0, 0.1};
  return motion;
}

RigidBody box() {
  RigidBody b;
  b.id = 1, b.mass = 1e3, b.principal_inertia = {3, 4, 5}, b.shape = BoxShape{{0.1, 0.05, 0.2}};
  return b;
}

TEST(DrivenBody, ComesToTheNextPlaceByTheVelocitiesOfASubstep) {
  Proxy p(box(), swing());
  const double t = 0.37, dt = 1e-3;
  p.drive(t, dt);
  const BodyMotion from = p.body.motion;
  const Vec3 corner(0.1, 0.05, 0.2);
  const Vec3 before = from.position + from.orientation * corner;
  EXPECT_LT((from.velocity * dt + from.position - swing()->at(t + dt).position).norm(), 1e-15);
  // A point turns with the spin; the chord of its arc differs by a share of the square of the angle.
  const Vec3 velocity = p.velocity_at(before);
  p.arrive(t + dt);
  const Vec3 after = p.body.motion.position + p.body.motion.orientation * corner;
  EXPECT_LT(((after - before) / dt - velocity).norm(), 2e-3 * velocity.norm());
  EXPECT_EQ(p.body.motion.velocity, from.velocity);
}

TEST(DrivenBody, IsNotMovedByImpulsesAndBooksThem) {
  Proxy p(box(), swing());
  p.drive(0.5, 1e-3);
  const BodyMotion before = p.body.motion;
  const Vec3 at = before.position + Vec3(0.1, 0, 0), j(1, 2, 3);
  EXPECT_TRUE(p.inverse_mass_at(at).isZero(0.0));
  EXPECT_DOUBLE_EQ(p.work(at, j), j.dot(p.velocity_at(at)));
  p.apply(at, -j);
  EXPECT_EQ(p.body.motion.velocity, before.velocity);
  EXPECT_EQ(p.body.motion.angular_momentum, before.angular_momentum);
  EXPECT_EQ(p.linear_impulse, -j);
  EXPECT_FALSE(p.is_free());
  EXPECT_TRUE(Proxy(box()).is_free());
}

// The arch grows from half its size to its whole size, about its corner.
Proxy growing() {
  std::vector<scene::Polygon> polygons;
  for (const auto& face : arch::mesh().faces) polygons.push_back({face, 0});
  Surface surface = scene::closed_surface(arch::mesh().points, polygons);
  std::vector<Vec3> whole = surface.corners;
  for (Vec3& c : surface.corners) c *= 0.5;
  auto motion = std::make_shared<DrivenMotion>();
  motion->still = {{1, 2, 3}, rotation_from_vector({0.3, -0.2, 0.5})};
  motion->shape = shape_curve({0.0, 2.0}, {surface.corners, whole});
  RigidBody b;
  b.id = 1, b.is_static = true;
  b.shape = ConvexShape{{}, std::make_shared<Surface>(surface)};
  return Proxy(b, motion);
}

TEST(DrivenBody, ThatGrowsHasTheDistanceAndTheVelocityOfItsSurface) {
  Proxy p = growing();
  const double t = 0.8, dt = 1e-4, s = t / 2.0;
  p.drive(t, dt);
  const double size = 0.5 + 0.5 * s * s * (3.0 - 2.0 * s), rate = 0.5 * 6.0 * s * (1.0 - s) / 2.0;
  const BodyMotion& m = p.body.motion;
  const Vec3 local(0.03 * size, 0.01 * size, arch::kHigh * size + 0.002);  // above the top
  const Vec3 world = m.position + m.orientation * local;
  EXPECT_NEAR(p.distance(world).value, 0.002, 1e-12);
  const Vec3 top(local.x(), local.y(), arch::kHigh * size);
  // The mean over dt differs from the rate at t by half of dt times its change.
  EXPECT_LT((p.velocity_at(world) - m.orientation * (rate / size * top)).norm(), 1e-4 * rate);
  EXPECT_NEAR(p.half_width(), 0.5 * arch::kHigh * size, 1e-12);
  EXPECT_TRUE(p.deforms());
}

TEST(DrivenBody, MovedSurfaceIsThatOfANewOne) {
  Proxy p = growing();
  p.drive(2.0, 0.0);
  std::vector<scene::Polygon> polygons;
  for (const auto& face : arch::mesh().faces) polygons.push_back({face, 0});
  const SolidDistance whole(scene::closed_surface(arch::mesh().points, polygons));
  for (int k = 0; k < 500; ++k) {
    const Vec3 x(0.09 * std::fmod(0.618 * k, 1.0) - 0.01, 0.05 * std::fmod(0.381 * k, 1.0) - 0.01,
                 0.08 * std::fmod(0.7548 * k, 1.0) - 0.01);
    const Vec3 world = p.body.motion.position + p.body.motion.orientation * x;
    EXPECT_NEAR(p.distance(world).value, whole.at(x).value, 1e-14);
  }
}

// What a checkpoint keeps of a body is its shape at that time, and the time.
TEST(DrivenBody, GoesOnFromACheckpointWithTheSameTriangles) {
  const Proxy small = growing();
  const Surface first = *std::get<ConvexShape>(small.body.shape).surface;
  auto motion = std::make_shared<DrivenMotion>();
  std::vector<Vec3> corners = first.corners;
  for (Vec3& c : corners) c = 2.0 * c.cwiseProduct(Vec3(3, 0.2, 1));
  motion->shape = shape_curve({0.0, 2.0}, {first.corners, corners});
  Proxy before(small.body, motion);
  before.drive(1.5, 1e-3), before.arrive(1.7);
  Proxy after(before.body, motion, before.arrived());
  EXPECT_DOUBLE_EQ(after.half_width(), before.half_width());
  for (Proxy* p : {&before, &after}) p->drive(1.7, 1e-3);
  for (const Vec3& corner : corners)  // at the corners several triangles are equally near
    for (const double off : {-0.004, 0.0, 0.004}) {
      const Vec3 x =
          before.body.motion.position + before.body.motion.orientation * Vec3(corner + off * Vec3(0.6, -0.3, 0.7));
      const Proxy::Distance a = before.distance(x), b = after.distance(x);
      EXPECT_EQ(a.value, b.value);
      EXPECT_EQ(a.triangle, b.triangle);
      EXPECT_EQ(before.velocity_at(x, a), after.velocity_at(x, b));
    }
}

TEST(DrivenBody, ThatGrowsIsSurelyBeyondOnlyWhatItIsBeyond) {
  Proxy p = growing();
  p.drive(0.0, 0.0);
  const auto world = [&](int k) {
    const Vec3 x(0.19 * std::fmod(0.618 * k, 1.0) - 0.05, 0.15 * std::fmod(0.381 * k, 1.0) - 0.05,
                 0.18 * std::fmod(0.7548 * k, 1.0) - 0.05);
    return Vec3(p.body.motion.position + p.body.motion.orientation * x);
  };
  std::vector<Proxy::Known> known;
  for (int k = 0; k < 500; ++k) known.push_back(p.known(world(k), p.distance(world(k))));
  const double least = 1e-3;
  EXPECT_FALSE(p.surely_beyond(world(0), Proxy::Known{}, least, 1e-12));  // nothing is known
  for (const double t : {0.0, 0.4, 0.8, 2.0}) {
    p.drive(t, 1e-4);
    int sure = 0, beyond = 0;
    for (int k = 0; k < 500; ++k) {
      const Vec3 x = world(k) + t * Vec3(2e-3, -1e-3, 3e-3);  // points move as well
      const bool far = p.distance(x).value > least;
      beyond += far;
      if (!p.surely_beyond(x, known[k], least, 1e-12)) continue;
      ++sure;
      EXPECT_TRUE(far) << k << " at " << t;
    }
    EXPECT_LE(sure, beyond);
    EXPECT_GE(sure, t == 0.0 ? beyond : t < 1.0 ? beyond / 2 : 0);  // it is of use
  }
}

TEST(DrivenMotion, TellsItsFastestPoint) {
  const auto motion = swing();
  double when = 0.0;
  // Smooth steps are fastest in the middle, at 1.5 times the mean; sixteen looks see it to a part in 500.
  const double fastest = motion->fastest(0.3, when);
  const double spin = 1.5 * 1.2, turned = 0.6;
  const Vec3 centre = Vec3(1.5 * 0.4 + 0.1 * spin * std::cos(turned), 0, 1.5 * 0.2 - 0.1 * spin * std::sin(turned));
  const double peak = centre.norm() + 0.3 * spin;
  EXPECT_NEAR(fastest, peak, peak / 500.0);
  EXPECT_NEAR(when, 0.5, 1.0 / 16.0 + 1e-12);
}

TEST(DrivenMotion, OfManyTurnsBetweenKeysIsAsFastAsOfFew) {
  for (const double turns : {0.5, 7.5, 8.0, 16.0, 31.0}) {
    PoseKey a, b;
    const Vec3 spin(0, 0, 2.0 * std::numbers::pi * turns);
    b.time = 1.0, b.turn = spin, a.spin = b.spin = spin;
    DrivenMotion motion;
    motion.path = PoseCurve({a, b});
    double when = 0.0;
    EXPECT_NEAR(motion.fastest(0.3, when), 0.3 * spin.norm(), 1e-9 * spin.norm()) << turns;
  }
}

}  // namespace
