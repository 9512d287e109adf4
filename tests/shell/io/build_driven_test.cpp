// Driven bodies of a scene: where they begin, how fast they are, and the mass at which engines see them.
#include "shell/io/build_driven.h"

#include <cmath>
#include <numbers>

#include "tests/coupler/small_scene.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

struct DrivenScene {
  scene::LoadedScene scene;
  proto::Body message;
  RigidBody body;
  DrivenScene() {
    scene.path = "driven.textproto";
    scene.message.set_window_s(1e-3);
    message.set_name("ball");
    body.id = 1, body.name = "ball", body.mass = 3.0, body.principal_inertia = Vec3(1, 2, 3);
    body.shape = SphereShape{0.1};
  }
  proto::PoseKey& key(double time, const Vec3& at) {
    proto::PoseKey& k = *message.add_motion();
    k.set_time_s(time);
    k.mutable_position()->set_x(at.x()), k.mutable_position()->set_y(at.y()), k.mutable_position()->set_z(at.z());
    return k;
  }
  std::shared_ptr<const DrivenMotion> make(double least_window = 0.0) {
    return make_driven(scene, "bodies[2]", message, least_window, body);
  }
  void expect_refused(const std::string& says, double least_window = 0.0) {
    try {
      make(least_window);
      ADD_FAILURE() << says;
    } catch (const Error& e) {
      EXPECT_EQ(e.status, Exit::kBadInput);
      EXPECT_EQ(e.field, "bodies[2].motion");
      EXPECT_NE(std::string(e.what()).find(says), std::string::npos) << e.what();
    }
  }
};

void add_linear(proto::PoseKey& key, double speed) { key.mutable_twist()->mutable_linear()->set_x(speed); }

}  // namespace

TEST(BuildDriven, WithoutMotionABodyIsLeftAsItIs) {
  DrivenScene s;
  s.body.motion.position = Vec3(1, 2, 3);
  EXPECT_EQ(s.make(), nullptr);
  EXPECT_EQ(s.body.motion.position, Vec3(1, 2, 3));
  EXPECT_EQ(s.body.mass, 3.0);
}

// Between keys with the velocity of their distance the speed is constant.
TEST(BuildDriven, AnEvenMotionHasItsSpeedAndBeginsAtItsFirstKey) {
  DrivenScene s;
  add_linear(s.key(0.0, {1, 2, 3}), 4.0), add_linear(s.key(0.5, {3, 2, 3}), 4.0);
  const auto motion = s.make();
  ASSERT_NE(motion, nullptr);
  EXPECT_FALSE(motion->deforms());
  EXPECT_NEAR(motion->top_speed, 4.0, 1e-12);  // round-off
  EXPECT_EQ(motion->last(), 0.5);
  EXPECT_EQ(s.body.motion.position, Vec3(1, 2, 3));
  EXPECT_EQ(s.body.motion.velocity, Vec3(0, 0, 0));  // placed at rest
  EXPECT_LT((motion->at(0.125).position - Vec3(1.5, 2, 3)).norm(), 1e-15);
  EXPECT_LT((motion->at(9.0).position - Vec3(3, 2, 3)).norm(), 1e-15);
}

// From rest to rest a cubic is 1.5 times as fast in the middle. The largest mean over an eighth of the time is less.
TEST(BuildDriven, FromRestToRestTheMiddleIsFastest) {
  DrivenScene s;
  s.key(0.0, {0, 0, 0}), s.key(1.0, {1, 0, 0});
  const double top = s.make()->top_speed;
  EXPECT_LE(top, 1.5);
  EXPECT_GT(top, 1.4);
}

// A point on the rim of a turning ball is as fast as the spin times the radius.
TEST(BuildDriven, ASpinMovesTheRim) {
  DrivenScene s;
  for (const double time : {0.0, 1.0}) {
    proto::PoseKey& k = s.key(time, {0, 0, 0});
    k.mutable_rotation()->mutable_axis()->set_z(1.0), k.mutable_rotation()->set_angle_deg(720.0 * time);
    k.mutable_twist()->mutable_angular()->set_z(4.0 * std::numbers::pi);
  }
  EXPECT_NEAR(s.make()->top_speed, 0.1 * 4.0 * std::numbers::pi, 1e-9);  // two whole turns count
}

TEST(BuildDriven, AWindowTakesABodyByItsWidthAtMost) {
  const auto moving = [](double speed) {
    DrivenScene s;  // 0.2 m wide, in windows of 1 ms
    add_linear(s.key(0.0, {0, 0, 0}), speed), add_linear(s.key(0.5, {0.5 * speed, 0, 0}), speed);
    return s;
  };
  EXPECT_NEAR(moving(199.0).make()->top_speed, 199.0, 1e-9);
  moving(400.0).expect_refused(
      "jumps: at 0 s 'ball' moves at 400 m/s, 0.4 m in a window, further than it is wide, 0.2 m; give more time "
      "between keys, or a window_s of 0.00025 s");
  moving(400.0).expect_refused("a shell takes no window short enough for that", 3e-4);
  moving(400.0).expect_refused("or a window_s of 0.00025 s", 2e-4);
  DrivenScene endless;
  endless.key(0.0, {0, 0, 0}), endless.key(1e-7, {1e305, 0, 0});
  endless.expect_refused("moves 'ball' faster than numbers can say");
}

TEST(BuildDriven, KeysWithAnOrientationOrNoneArePlaced) {
  DrivenScene s;
  proto::Quaternion& q = *s.key(0.0, {0, 0, 0}).mutable_orientation();
  q.set_w(0.0), q.set_z(1.0);  // half a turn about z
  s.key(1.0, {0, 0, 0});
  s.make();
  EXPECT_LT((s.body.motion.orientation * Vec3::UnitX() + Vec3::UnitX()).norm(), 1e-15);
}

// Nothing else of the run moves a driven body: it has ten thousand times the mass of all that is not driven.
TEST(DrivenMasses, AreLargeAgainstEverythingElse) {
  RunSetup setup = small_scene::built(small_scene::kScene);
  const double shell = 2500.0 * 0.004 * 0.25, ball = setup.bodies[0].mass;
  RigidBody driven = setup.bodies[0], still = setup.bodies[0];
  driven.mass = 7.0, driven.principal_inertia = Vec3(1, 2, 3);
  still.is_static = true, still.mass = 0.0, still.principal_inertia.setZero();
  setup.bodies = {setup.bodies[0], driven, still, driven};
  setup.bodies[3].mass = 1.0;
  const auto motion = std::make_shared<DrivenMotion>();
  setup.driven = {nullptr, motion, motion, motion};
  set_driven_masses(setup);
  EXPECT_EQ(setup.bodies[0].mass, ball);
  const double large = 1e4 * (shell + ball);
  EXPECT_NEAR(setup.bodies[1].mass, large, 1e-9 * large);  // mass of a shell is a sum over control points
  EXPECT_NEAR(setup.bodies[3].mass, large, 1e-9 * large);
  EXPECT_LT((setup.bodies[1].principal_inertia - large / 7.0 * Vec3(1, 2, 3)).norm(), 1e-9 * large);
  EXPECT_EQ(setup.bodies[2].mass, 0.0);
}

TEST(DrivenMasses, WithoutAnythingElseAreThoseOfThemselves) {
  RunSetup setup;
  RigidBody body;
  body.mass = 2.0, body.principal_inertia = Vec3(1, 1, 2);
  setup.bodies = {body, body};
  setup.driven = {std::make_shared<DrivenMotion>(), std::make_shared<DrivenMotion>()};
  set_driven_masses(setup);
  for (const RigidBody& b : setup.bodies) {
    EXPECT_EQ(b.mass, 4e4);
    EXPECT_EQ(b.principal_inertia, Vec3(2e4, 2e4, 4e4));
  }
}
