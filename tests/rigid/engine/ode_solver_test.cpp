#include "rigid/engine/ode_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/rigid/trial.h"

namespace sunder::rigid {
namespace {

using namespace testing;  // NOLINT: the helpers of this folder

constexpr double kOdeWindow = 0.25e-3;  // [s]

/// Distance that a box slides down a slope of this angle in half a second [m].
double slid(double degrees, double azimuth, double friction, bool on_box) {
  OdeEngine engine;
  engine.set_contact_laws({{0, 1, friction, 0.0}});
  Caller caller(engine, kOdeWindow, kGravity);
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

TEST(OdeEngine, RefusesPartsOfMoreCornersThanItTakes) {
  RigidBody fine = plate(1, {rectangle(0, 0, 0.02, 0.01)}, 0.003), rough = fine;
  std::get<ConvexShape>(fine.shape).parts[0].resize(513, Vec3::Zero());  // inside it
  OdeEngine engine;
  EXPECT_EQ(kind_of([&] { engine.add(fine); }), "bad_body");
  std::get<ConvexShape>(rough.shape).parts[0].resize(512, Vec3::Zero());
  engine.add(rough);
}

}  // namespace
}  // namespace sunder::rigid
