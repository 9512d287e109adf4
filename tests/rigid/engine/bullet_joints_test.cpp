#include <gtest/gtest.h>

#include <utility>

#include "tests/rigid/trial.h"

namespace sunder::rigid {
namespace {

using namespace testing;  // NOLINT: the helpers of this folder

constexpr double kJointWindow = Trial::kWindow;
using Kind = Joint::Kind;
constexpr Kind kKinds[] = {Kind::kBall, Kind::kHinge, Kind::kSlider, Kind::kFixed};

Joint joint(std::uint32_t id, Kind kind, BodyId first, BodyId second, const Vec3& on_first, const Vec3& on_second,
            const Quat& axes = Quat::Identity()) {
  return {id, "joint", kind, first, second, {on_first, axes}, {on_second, axes}};
}

Vec3 on_body(const RigidBody& body, const Vec3& point) {
  return body.motion.position + body.motion.orientation * point;
}

/// Largest strain of a joint [m or rad].
double strain(const Joint& joint, const RigidBody& a, const RigidBody& b) {
  const Quat qa = a.motion.orientation * joint.first_frame.orientation,
             qb = b.motion.orientation * joint.second_frame.orientation;
  Vec3 apart = qa.conjugate() * (on_body(b, joint.second_frame.position) - on_body(a, joint.first_frame.position));
  Vec3 turn = rotation_vector(qa.conjugate() * qb);
  if (joint.kind == Kind::kSlider) apart.z() = 0.0;
  if (joint.kind == Kind::kBall) turn.setZero();
  if (joint.kind == Kind::kHinge) turn = (qa * Vec3::UnitZ()).cross(qb * Vec3::UnitZ());
  return std::max(apart.norm(), turn.norm());
}

struct Momenta {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
};
Momenta momenta(const Caller& caller) {
  Momenta sum;
  for (const auto& [id, b] : caller.bodies()) {
    sum.linear += b.mass * b.motion.velocity;
    sum.angular += b.motion.angular_momentum + b.mass * b.motion.position.cross(b.motion.velocity);
  }
  return sum;
}

/// A chain of rods that hangs from the world, turned up by 1.1 rad. Hinges turn about y.
struct Chain {
  static constexpr double kLength = 0.1;  // [m]
  Trial trial;
  std::vector<Joint> joints;

  Chain(Kind kind, int links, double window_s) : trial(Scene{}, window_s) {
    const Quat axes(Eigen::AngleAxisd(-0.5 * EIGEN_PI, Vec3::UnitX()));
    const Vec3 end(0.5 * kLength, 0, 0);
    for (int i = 0; i < links; ++i) {
      RigidBody rod = box(static_cast<BodyId>(i + 1), Vec3(0.5 * kLength, 0.01, 0.005), 0.1);
      rod.motion.orientation = Quat(Eigen::AngleAxisd(1.1, Vec3::UnitY()));
      rod.motion.position = rod.motion.orientation * Vec3((i + 0.5) * kLength, 0, 0);
      if (kind == Kind::kBall) rod.motion.angular_momentum = rod.apply_inertia(rod.motion.orientation * Vec3(5, 0, 0));
      trial.caller.add(rod);
      joints.push_back(joint(i + 1, kind, i + 1, i, -end, i == 0 ? Vec3(Vec3::Zero()) : end, axes));
      trial.engine.add_joint(joints.back());
    }
  }
  double strained() const {
    double worst = 0.0;
    const RigidBody world;
    for (const Joint& j : joints)
      worst = std::max(worst, strain(j, trial.caller.body(j.first), j.second ? trial.caller.body(j.second) : world));
    return worst;
  }
};

TEST(BulletJoints, EnergyOfPendulumsAndChainsDoesNotDrift) {
  for (double window : {kJointWindow, 1e-3})
    for (const auto& [kind, links] :
         {std::pair(Kind::kHinge, 1), {Kind::kBall, 1}, {Kind::kHinge, 5}, {Kind::kBall, 5}}) {
      Chain chain(kind, links, window);
      const double before = chain.trial.caller.energy();
      double kinetic = 0.0, off = 0.0, strained = 0.0, late = 0.0;
      for (int i = 0; i < 10000; ++i) {
        chain.trial.caller.window();
        kinetic = std::max(kinetic, chain.trial.caller.kinetic_energy());
        off = std::max(off, std::abs(chain.trial.caller.energy() - before));
        if (i >= 5000) late = std::max(late, std::abs(chain.trial.caller.energy() - before));
        strained = std::max(strained, chain.strained());
      }
      // The energy oscillates by a share of order H |w|, because the caller's gravity is not centred in the window. It
      // does not drift: the error in the second half is no larger.
      EXPECT_GT(kinetic, 5e-3);
      EXPECT_LT(off, 2.0 * window * kinetic) << window << " s, " << links;
      EXPECT_LT(late, 1.05 * off + 1e-9) << window << " s, " << links;
      EXPECT_LT(strained, 2e-11) << window << " s, " << links;
    }
}

TEST(BulletJoints, ASmallPendulumKeepsItsTime) {
  Trial trial(Scene{});
  RigidBody rod = box(1, Vec3(0.05, 0.01, 0.005), 0.1);
  const double angle = 0.01;
  rod.motion.orientation = Quat(Eigen::AngleAxisd(0.5 * EIGEN_PI + angle, Vec3::UnitY()));
  rod.motion.position = rod.motion.orientation * Vec3(0.05, 0, 0);
  trial.caller.add(rod);
  trial.engine.add_joint(joint(1, Kind::kHinge, 1, 0, Vec3(-0.05, 0, 0), Vec3::Zero(),
                               Quat(Eigen::AngleAxisd(-0.5 * EIGEN_PI, Vec3::UnitX()))));
  const double inertia = rod.principal_inertia.y() + rod.mass * 0.05 * 0.05;
  const double period = 2.0 * EIGEN_PI * std::sqrt(inertia / (rod.mass * kGravity * 0.05));
  trial.caller.run(10.25 * period);  // a zero of the swing
  const double x = trial.caller.body(1).motion.position.x();
  // a hundredth of the amplitude is 1/6400 of these ten periods
  EXPECT_LT(std::abs(x), 0.01 * 0.05 * angle);
}

TEST(BulletJoints, FreePairsKeepMomentumAndEnergy) {
  for (const Kind kind : kKinds) {
    Trial trial(Scene{}, kJointWindow, 0.0);
    RigidBody a = box(1, Vec3(0.05, 0.02, 0.01), 0.3), b = box(2, Vec3(0.03, 0.03, 0.01), 0.1);
    b.motion.position = Vec3(0.08, 0.01, 0);
    a.motion.velocity = Vec3(0.3, 0.2, -0.5);
    b.motion.velocity = Vec3(-0.3, 1, 0.2);
    a.motion.angular_momentum = a.apply_inertia(Vec3(3, -5, 2));
    trial.caller.add(a), trial.caller.add(b);
    const Joint held = joint(1, kind, 1, 2, Vec3(0.05, 0, 0), Vec3(-0.03, -0.01, 0));
    trial.engine.add_joint(held);
    const Momenta start = momenta(trial.caller);
    trial.caller.window();  // removes velocities that the joint forbids
    const double energy = trial.caller.kinetic_energy();
    EXPECT_LT(energy, a.kinetic_energy() + b.kinetic_energy());
    for (int i = 0; i < 10000; ++i) {
      trial.caller.window();
      const Momenta now = momenta(trial.caller);
      ASSERT_LT((now.linear - start.linear).norm(), 1e-12 * start.linear.norm()) << i;
      ASSERT_LT((now.angular - start.angular).norm(), 1e-11 * start.angular.norm()) << i;
      ASSERT_NEAR(trial.caller.kinetic_energy(), energy, 1e-6 * energy) << i;  // (|w| H)^2 = 1e-5
      ASSERT_LT(strain(held, trial.caller.body(1), trial.caller.body(2)), 2e-11) << i;
    }
  }
}

TEST(BulletJoints, ASliderFallsAlongItsAxisOnly) {
  Trial trial(Scene{});
  RigidBody bead = box(1, Vec3(0.02, 0.01, 0.01), 0.1);
  bead.motion.velocity = Vec3(1, 2, 0.5);
  bead.motion.angular_momentum = bead.apply_inertia(Vec3(10, 20, 30));
  trial.caller.add(bead);
  const double tilt = 0.6;
  const Quat axes(Eigen::AngleAxisd(tilt, Vec3::UnitY()));
  const Vec3 axis = axes * Vec3::UnitZ();
  trial.engine.add_joint(joint(1, Kind::kSlider, 1, 0, Vec3::Zero(), Vec3::Zero(), axes));
  trial.caller.window();
  const double speed = axis.dot(trial.caller.body(1).motion.velocity);
  trial.windows(1000);
  const BodyMotion& end = trial.caller.body(1).motion;
  const double expected = speed - 1000 * kJointWindow * kGravity * std::cos(tilt);
  EXPECT_LT((end.velocity - expected * axis).norm(), 1e-9);
  EXPECT_LT(end.position.cross(axis).norm(), 1e-11);
  EXPECT_LT(rotation_vector(end.orientation).norm(), 1e-11);
}

TEST(BulletJoints, LinkedBodiesDoNotCollide) {
  for (const bool at_once : {true, false}) {
    Trial trial(Scene{}, kJointWindow, 0.0);
    RigidBody a = box(1, Vec3::Constant(0.02), 1.0), b = a;
    b.id = 2;
    a.motion.position.x() = -0.03, b.motion.position.x() = 0.03;
    a.motion.velocity.x() = 0.5, b.motion.velocity.x() = -0.5;
    trial.caller.add(a), trial.caller.add(b);
    const Joint slider = joint(1, Kind::kSlider, 1, 2, Vec3::Zero(), Vec3::Zero(),
                               Quat(Eigen::AngleAxisd(0.5 * EIGEN_PI, Vec3::UnitY())));
    if (at_once) trial.engine.add_joint(slider);
    trial.windows(75);  // 1.25 mm before they would meet: contacts exist already
    if (!at_once) trial.engine.add_joint(slider);
    EXPECT_TRUE(trial.engine.rows(kJointWindow, trial.motions(), {1}).empty());
    trial.windows(400);
    EXPECT_NEAR(trial.caller.body(1).motion.velocity.x(), 0.5, 1e-12);  // through one another
    EXPECT_GT(trial.caller.body(1).motion.position.x(), trial.caller.body(2).motion.position.x());
  }
}

TEST(BulletJoints, JointsAndContactsHoldAtOnce) {
  for (const Kind kind : kKinds) {
    Scene scene;
    scene.bodies.push_back(half_space(9));
    RigidBody a = box(1, Vec3(0.05, 0.02, 0.01), 0.3), b = box(2, Vec3(0.03, 0.02, 0.01), 0.1),
              load = box(3, Vec3(0.02, 0.02, 0.02), 1.0);
    a.motion.position = Vec3(0, 0, 0.05);
    b.motion.position = Vec3(0.09, 0, 0.05);
    load.motion.position = Vec3(0.0, 0, 0.09);
    for (const RigidBody& body : {a, b, load}) scene.bodies.push_back(body);
    Trial trial(scene);
    const Joint held = joint(1, kind, 1, 2, Vec3(0.055, 0, 0), Vec3(-0.035, 0, 0));
    trial.engine.add_joint(held);
    const double before = trial.caller.energy();
    double most = -1e300, strained = 0.0;
    for (int i = 0; i < 3000; ++i) {
      trial.caller.window();
      most = std::max(most, trial.caller.energy());
      strained = std::max(strained, strain(held, trial.caller.body(1), trial.caller.body(2)));
    }
    EXPECT_LT(most, before + 1e-9) << static_cast<int>(kind);
    EXPECT_LT(strained, 1e-8) << static_cast<int>(kind);
    EXPECT_NEAR(trial.caller.body(1).motion.position.z(), 0.01, 1e-4);
    EXPECT_NEAR(trial.caller.body(2).motion.position.z(), 0.01, 1e-4);
    for (const auto& [id, body] : trial.caller.bodies()) EXPECT_LT(body.motion.velocity.norm(), 0.01) << id;
  }
}

TEST(BulletJoints, BodiesAtRestStayAtRestBesideAChainThatHits) {
  // with joints and contacts, contacts are solved several times in a window
  Trial trial(Scene{});
  RigidBody floor = half_space(1), post = box(2, Vec3(0.1, 0.1, 0.1), 1.0);
  post.is_static = true, post.motion.position = Vec3(0.3, 0, 0.1);
  trial.caller.add(floor), trial.caller.add(post);
  RigidBody trunk = box(3, Vec3(0.3, 0.02, 0.02), 2.0), branch = box(9, Vec3(0.02, 0.02, 0.1), 0.3);
  trunk.motion.position = Vec3(0.3, 0, 0.3), branch.motion.position = Vec3(0.5, 0, 0.42);
  trial.caller.add(trunk), trial.caller.add(branch);
  for (BodyId id = 4; id < 8; ++id) {
    RigidBody crate = box(id, Vec3(0.05, 0.05, 0.01), 0.1);
    crate.motion.position = Vec3(0.3 * id, 1.0, 0.02 * id);
    trial.caller.add(crate);
  }
  RigidBody lid = box(8, Vec3(0.05, 0.05, 0.01), 0.1);  // on the first of them
  lid.motion.position = Vec3(1.2, 1.0, 0.11);
  trial.caller.add(lid);
  trial.engine.add_joint(joint(1, Kind::kHinge, 3, 0, Vec3(-0.3, 0, 0), Vec3(0, 0, 0.3),
                               Quat(Eigen::AngleAxisd(-0.5 * EIGEN_PI, Vec3::UnitX()))));
  trial.engine.add_joint(joint(2, Kind::kFixed, 9, 3, Vec3(0, 0, -0.12), Vec3(0.2, 0, 0)));
  double lowest = 1.0;
  for (int i = 0; i < 2000; ++i) {
    trial.caller.window();
    for (BodyId id = 4; id < 9; ++id) lowest = std::min(lowest, trial.caller.body(id).motion.position.z());
  }
  EXPECT_GT(lowest, 0.01 - 1e-4);
}

TEST(BulletJoints, StrainIsReducedWithoutEnergy) {
  for (const Kind kind : kKinds) {
    Trial trial(Scene{}, kJointWindow, 0.0);
    RigidBody a = box(1, Vec3(0.05, 0.02, 0.01), 0.3), b = box(2, Vec3(0.03, 0.03, 0.01), 0.1);
    b.motion.position = Vec3(0.081, 0.0005, 0.0);
    b.motion.orientation = rotation_from_vector(Vec3(0.01, 0.02, 0.0));
    trial.caller.add(a), trial.caller.add(b);
    const Joint held = joint(1, kind, 1, 2, Vec3(0.05, 0, 0), Vec3(-0.03, 0, 0));
    trial.engine.add_joint(held);
    double most = 0.0;
    ASSERT_GT(strain(held, a, b), 5e-4);
    for (int i = 0; i < 400; ++i) {
      trial.caller.window();
      most = std::max(most, trial.caller.kinetic_energy());
    }
    // The correction moves at up to 0.05 m/s and 1 rad/s, or 1e-4 J. The remaining energy is of second order in the
    // strain.
    EXPECT_LT(most, 1e-7) << static_cast<int>(kind);
    EXPECT_LT(strain(held, trial.caller.body(1), trial.caller.body(2)), 1e-6) << static_cast<int>(kind);
  }
}

TEST(BulletJoints, JointsOfSolvedBodiesAreLeftOut) {
  Chain chain(Kind::kBall, 3, kJointWindow);
  chain.trial.windows(50);
  std::vector<PredictedState> down = chain.trial.motions();
  for (PredictedState& m : down) {
    m.motion.velocity.z() -= kGravity * kJointWindow;
    m.motion.position += kJointWindow * m.motion.velocity;
  }
  chain.trial.engine.advance(kJointWindow, down, {2});
  const auto states = chain.trial.engine.states();
  EXPECT_EQ(bits(states[1].motion), bits(down[1].motion));
  EXPECT_EQ(bits(states[2].motion), bits(down[2].motion));  // held by 2 only
  EXPECT_NE(bits(states[0].motion), bits(down[0].motion));  // held by the world as well
}

TEST(BulletJoints, AJointAtRestLeavesPredictedStatesToTheBit) {
  Trial trial(Scene{}, kJointWindow, 0.0);
  RigidBody a = box(1, Vec3::Constant(0.02), 1.0), b = a;
  b.id = 2;
  b.motion.position.x() = 0.05;
  trial.caller.add(a), trial.caller.add(b);
  trial.engine.add_joint(joint(1, Kind::kFixed, 1, 2, Vec3(0.05, 0, 0), Vec3::Zero()));
  const std::string before = bits(trial.engine);
  trial.windows(20);
  EXPECT_EQ(bits(trial.engine), before);
}

TEST(BulletJoints, TwoHingesOfOneDoorAgree) {  // redundant: their matrix is singular
  Trial trial(Scene{});
  RigidBody door = box(1, Vec3(0.1, 0.01, 0.2), 1.0);
  door.motion.position = Vec3(0.1, 0, 0);
  door.motion.angular_momentum = door.apply_inertia(Vec3(0, 0, 3));
  door.motion.velocity = Vec3(0, 0.3, 0);
  trial.caller.add(door);
  for (const double z : {-0.15, 0.15})
    trial.engine.add_joint(joint(z < 0 ? 1 : 2, Kind::kHinge, 1, 0, Vec3(-0.1, 0, z), Vec3(0, 0, z)));
  const double before = trial.caller.energy();
  trial.windows(4000);
  EXPECT_NEAR(trial.caller.energy(), before, 1e-4 * before);
  EXPECT_NEAR(trial.caller.body(1).angular_velocity().z(), 3.0, 1e-3);
  EXPECT_NEAR(trial.caller.body(1).motion.position.z(), 0.0, 1e-9);
}

TEST(BulletJoints, RefusesJointsOfNothingThatMoves) {
  BulletEngine engine;
  RigidBody wall = box(4, Vec3::Constant(1.0), 1.0);
  wall.is_static = true;
  engine.add(half_space(3)), engine.add(wall), engine.add(sphere(1, 0.01, 1.0));
  for (const auto& [first, second] : {std::pair(3u, 4u), {4u, 0u}})
    EXPECT_EQ(kind_of([&] { engine.add_joint(joint(1, Kind::kBall, first, second, Vec3::Zero(), Vec3::Zero())); }),
              "bad_joint");
  engine.add_joint(joint(1, Kind::kBall, 1, 4, Vec3::Zero(), Vec3::Zero()));  // one of them moves
}

}  // namespace
}  // namespace sunder::rigid
