// Joints: free motions follow theory, held ones do not occur.
#include <algorithm>
#include <cmath>

#include "tests/conformance/suite.h"

namespace sunder::conformance {
namespace {

using namespace link::capability;

// Ten seconds have 10000 windows: an anchor that creeps by 10 nm in each moves by as much as a picture shows
// (resting.cpp).
constexpr double kAnchor_m = 1e-4;
constexpr double kAxis_rad = 1e-3;  // the same at the end of an arm of 0.1 m
// The error of the period is of first or second order in omega H, which is 6e-3 for these pendulums: 0.2 %.
constexpr double kPeriodTolerance = 2e-3;
// A joint solved on velocities turns them by omega H in each window and loses (omega H)^2 of the kinetic energy: about
// 0.1 % a second here. It must not gain: energy that grows in 10 s diverges later.
constexpr double kLossTolerance = 2e-2, kJointGain = 1e-3;
constexpr double kMotionTolerance = 1e-2;  // of free motions: friction would be larger
// The impulses of a joint are equal and opposite (collisions.cpp), in 1000 windows.
constexpr double kJointMomentum = 1e-12;
// Correcting the anchors moves bodies without their velocities, by a share (omega H)^2 of the arm in each window.
constexpr double kTurnTolerance = 1e-3;

Joint joint(Joint::Kind kind, BodyId first, BodyId second, const Vec3& first_point, const Vec3& second_point,
            const Quat& first_turn = Quat::Identity(), const Quat& second_turn = Quat::Identity()) {
  return {1, "joint", kind, first, second, {first_point, first_turn}, {second_point, second_turn}};
}

struct Frame {
  Vec3 position;
  Quat orientation;
};

Frame placed(const Play& play, BodyId id, const Joint::Frame& frame) {
  if (id == 0) return {frame.position, frame.orientation};
  const BodyMotion& m = play.body(id).motion;
  return {m.position + m.orientation * frame.position, m.orientation * frame.orientation};
}

Vec3 gap(const Play& play, const Joint& j) {
  return placed(play, j.first, j.first_frame).position - placed(play, j.second, j.second_frame).position;
}

double axis_error(const Play& play, const Joint& j) {
  const Vec3 a = placed(play, j.first, j.first_frame).orientation * Vec3::UnitZ();
  const Vec3 b = placed(play, j.second, j.second_frame).orientation * Vec3::UnitZ();
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

double turn_error(const Play& play, const Joint& j) {
  return rotation_vector(placed(play, j.first, j.first_frame).orientation *
                         placed(play, j.second, j.second_frame).orientation.conjugate())
      .norm();
}

// A rod that hangs by its upper end from the world, released at 10 degrees.
void pendulum(Suite& s) {
  const Vec3 half(0.01, 0.01, 0.15), up(0, 0, half.z());
  const double angle = 10.0 * EIGEN_PI / 180.0;
  RigidBody rod = box(1, half);
  rod.motion.orientation = rotation_from_vector({0, angle, 0});
  rod.motion.position = -(rod.motion.orientation * up);
  const Joint ball = joint(Joint::Kind::kBall, 1, 0, up, Vec3::Zero());
  Play play(s.target, {{{rod}, {}, {ball}}, gravity()});
  const auto energy = [&] {
    return play.kinetic_energy() + rod.mass * kGravity * (play.body(1).motion.position.z() + half.z());
  };
  const double swing = energy(), about_pivot = rod.principal_inertia.y() + rod.mass * half.z() * half.z();
  // Period to the fourth order of the angle.
  const double period = 2.0 * EIGEN_PI * std::sqrt(about_pivot / (rod.mass * kGravity * half.z())) *
                        (1.0 + angle * angle / 16.0 + 11.0 / 3072.0 * angle * angle * angle * angle);
  double first = -1.0, last = -1.0, anchor = 0.0, most = swing, before = play.body(1).motion.position.x();
  int crossings = 0;
  for (int i = 0; i < 10000; ++i) {
    play.window();
    const double now = play.body(1).motion.position.x();
    if ((before > 0.0) != (now > 0.0)) {
      last = play.time() - 1e-3 * now / (now - before), ++crossings;
      if (crossings == 1) first = last;
    }
    before = now, anchor = std::max(anchor, gap(play, ball).norm()), most = std::max(most, energy());
  }
  s.report.check("period", crossings > 2 ? 2.0 * (last - first) / (crossings - 1) : NAN, period, kPeriodTolerance,
                 "[s], over 10 s");
  s.report.check("energy", energy(), swing, kLossTolerance, "[J], after 10 s");
  s.report.check("gain", most / swing - 1.0, 0.0, kJointGain, "largest energy, relative gain over the first");
  s.report.check("anchor", anchor, 0.0, kAnchor_m, "gap [m], worst in 10 s");
  play.end();
}

// A door that swings about a horizontal axis by its weight.
void hinge(Suite& s) {
  const Vec3 half(0.1, 0.01, 0.15), edge(-half.x(), 0, 0);
  const Quat level = rotation_from_vector({0.5 * EIGEN_PI, 0, 0});  // its z axis along the world's -y
  RigidBody door = box(1, half);
  door.motion.orientation = level;
  door.motion.position = -(level * edge);
  const Joint pin = joint(Joint::Kind::kHinge, 1, 0, edge, Vec3::Zero(), Quat::Identity(), level);
  Play play(s.target, {{{door}, {}, {pin}}, gravity()});
  double axis = 0.0, anchor = 0.0, lowest = 0.0;
  for (int i = 0; i < 10000; ++i) {
    play.window();
    axis = std::max(axis, axis_error(play, pin)), anchor = std::max(anchor, gap(play, pin).norm());
    if (i < 1000) lowest = std::min(lowest, play.body(1).motion.position.z());
  }
  s.report.check("axis", axis, 0.0, kAxis_rad, "[rad], worst in 10 s");
  s.report.check("anchor", anchor, 0.0, kAnchor_m, "gap [m], worst in 10 s");
  s.report.check("swings", lowest / half.x(), -1.0, kMotionTolerance,
                 "lowest point in the first second, relative to its arm");
  play.end();
}

// A box slides down a rail at 30 degrees, with its centre beside the rail.
void slider(Suite& s) {
  const double slope = 30.0 * EIGEN_PI / 180.0;
  const Quat rail = rotation_from_vector({0, EIGEN_PI / 2 + slope, 0});  // z points down the rail
  const Vec3 beside(0, 0.02, 0.03), along = rail * Vec3::UnitZ();
  const RigidBody block = at(box(1, {0.05, 0.02, 0.03}), -beside);
  const Joint line = joint(Joint::Kind::kSlider, 1, 0, beside, Vec3::Zero(), rail, rail);
  Play play(s.target, {{{block}, {}, {line}}, gravity()});
  double off = 0.0, turn = 0.0;
  const auto watch = [&](int windows) {
    for (int i = 0; i < windows; ++i) {
      play.window();
      const Vec3 d = gap(play, line);
      off = std::max(off, (d - d.dot(along) * along).norm()), turn = std::max(turn, turn_error(play, line));
    }
  };
  watch(1000);
  s.report.check("distance", gap(play, line).dot(along), 0.5 * kGravity * std::sin(slope), kMotionTolerance,
                 "[m], in the first second");
  watch(1000);
  s.report.check("line", off, 0.0, kAnchor_m, "off its line [m], worst in 2 s");
  s.report.check("turn", turn, 0.0, kAxis_rad, "[rad]");
  play.end();
}

void cantilever(Suite& s) {
  const Vec3 half(0.15, 0.02, 0.02), end(-half.x(), 0, 0);
  const Joint clamp = joint(Joint::Kind::kFixed, 1, 0, end, end);
  Play play(s.target, {{{box(1, half)}, {}, {clamp}}, gravity()});
  double off = 0.0, turn = 0.0;
  for (int i = 0; i < 10000; ++i) {
    play.window();
    off = std::max(off, gap(play, clamp).norm()), turn = std::max(turn, turn_error(play, clamp));
  }
  s.report.check("anchor", off, 0.0, kAnchor_m, "[m], worst in 10 s");
  s.report.check("turn", turn, 0.0, kAxis_rad, "[rad]");
  play.end();
}

// Two linked boxes tumble about one another in free flight.
void linked(Suite& s) {
  const Vec3 half(0.05, 0.03, 0.02), right(0.06, 0, 0);
  const RigidBody a = moving(at(box(1, half), -right), {1, -0.3, 0.2}, {0, 0, 5.0});
  const RigidBody b = moving(at(box(2, half), right), {1, 0.3, 0.2}, {0, 0, 5.0});
  const Joint ball = joint(Joint::Kind::kBall, 1, 2, right, -right);
  Play play(s.target, {{{a, b}, {}, {ball}}});
  const Vec3 centre = play.centre_of_mass(), linear = play.momentum(), angular = play.angular_momentum(centre);
  const double start = play.kinetic_energy();
  double change = 0.0, anchor = 0.0, most = start;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 before = play.momentum();
    play.window();
    change = std::max(change, (play.momentum() - before).norm() / linear.norm());
    anchor = std::max(anchor, gap(play, ball).norm()), most = std::max(most, play.kinetic_energy());
  }
  const Vec3 moved = centre + linear / (a.mass + b.mass);  // the centre of mass moves on a straight line
  s.report.check("linear", change, 0.0, s.exact(kJointMomentum), "worst change in a window");
  s.report.check("path", (play.centre_of_mass() - moved).norm(), 0.0, kAnchor_m, "of the centre of mass in 1 s [m]");
  s.report.check("angular", (play.angular_momentum(moved) - angular).norm() / angular.norm(), 0.0, kTurnTolerance,
                 "after 1 s");
  s.report.check("gain", most / start - 1.0, 0.0, kJointGain, "largest kinetic energy, relative gain");
  s.report.check("anchor", anchor, 0.0, kAnchor_m, "gap [m]");
  play.end();
}

// A pendulum is released at the bottom and flies on; another one beside it still hangs. The release changes no motion,
// so the flight is exact.
void released(Suite& s) {
  const Vec3 half(0.01, 0.01, 0.15), up(0, 0, half.z());
  const auto hung = [&](BodyId id, double y) {
    RigidBody rod = box(id, half);
    rod.motion.orientation = rotation_from_vector({0, 0.5, 0});
    rod.motion.position = Vec3(0, y, 0) - rod.motion.orientation * up;
    return rod;
  };
  const Joint one = joint(Joint::Kind::kBall, 1, 0, up, Vec3::Zero());
  Joint other = joint(Joint::Kind::kBall, 2, 0, up, {0, 1, 0});
  other.id = 2;
  Play play(s.target, {{{hung(1, 0), hung(2, 1)}, {}, {one, other}}, gravity()});
  play.run(0.2);
  play.release(1);
  const RigidBody before = play.body(1);
  double off = 0.0, anchor = 0.0;
  for (int i = 0; i < 500; ++i) {
    play.window();
    off = std::max({off, pose_error(play.states()[0].motion, play.predicted()[0].motion, 0.3),
                    velocity_error(play.states()[0].motion, play.predicted()[0].motion)});
    anchor = std::max(anchor, gap(play, other).norm());
  }
  s.report.check("flies", off, 0.0, s.exact(1e-9), "off its predicted state, worst in 0.5 s");
  const Vec3 path = before.motion.position + 0.5 * before.motion.velocity + 0.125 * gravity();
  s.report.check("path", (play.body(1).motion.position - path).norm(), 0.0, s.exact(1e-9), "of its centre [m]");
  s.report.check("others", anchor, 0.0, kAnchor_m, "gap of the other joint [m]");
  play.end();
}

// Two linked boxes overlap. After the release of the joint they still do not collide.
void parted(Suite& s) {
  const Vec3 half(0.05, 0.03, 0.02), right(0.03, 0, 0);
  const RigidBody a = moving(at(box(1, half), -right), {0, 0, 0.1}, {0, 0, 2.0});
  const RigidBody b = moving(at(box(2, half), right), {0, 0, -0.1}, {0, 0, 2.0});
  const Joint ball = joint(Joint::Kind::kBall, 1, 2, right, -right);
  Play play(s.target, {{{a, b}, law(0.5, 0.0), {ball}}});
  play.run(0.02);
  play.release(1);
  double off = 0.0;
  for (int i = 0; i < 300; ++i) {
    play.window();
    for (int k = 0; k < 2; ++k)
      off = std::max({off, pose_error(play.states()[k].motion, play.predicted()[k].motion, 0.1),
                      velocity_error(play.states()[k].motion, play.predicted()[k].motion)});
  }
  s.report.check("through", off, 0.0, s.exact(1e-9), "off their predicted states, worst in 0.3 s");
  s.report.check_error("apart", gap(play, ball).norm(), 0.005, std::max(0.0, 0.005 - gap(play, ball).norm()), 0.0,
                       "distance of the two at the end [m]");
  play.end();
}

}  // namespace

std::vector<Case> joint_cases() {
  const auto one = [](const char* name, const char* what, void (*run)(Suite&)) {
    return Case{name, what, {kBoxes, kJoints}, run};
  };
  return {
      one("joint_ball", "a pendulum: period, energy, anchor", pendulum),
      one("joint_hinge", "a hinge keeps its axis and swings", hinge),
      one("joint_slider", "a slider keeps its line and slides", slider),
      one("joint_fixed", "a fixed joint holds a cantilever", cantilever),
      one("joint_linked", "two free bodies linked by a ball joint", linked),
      {"joint_released", "a released pendulum flies on", {kBoxes, kJoints, kReleaseJoints}, released},
      {"joint_parted", "bodies linked before still do not collide", {kBoxes, kJoints, kReleaseJoints}, parted},
  };
}

}  // namespace sunder::conformance
