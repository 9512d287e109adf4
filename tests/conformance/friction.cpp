// Coulomb friction: the angle at which a block slides, its acceleration, and a sliding ball that starts to roll.
#include <cmath>

#include "tests/conformance/suite.h"

namespace sunder::conformance {
namespace {

using namespace link::capability;

constexpr double kMu = 0.5;
// A block at rest on a slope may settle but not creep: a tenth of a millimetre in 0.8 s. Without friction it would
// slide by 1.3 m.
constexpr double kCreep_m = 1e-4;
// The acceleration is the difference of weight and friction, a tenth of either. So 3 % of it is 0.3 % of the friction.
constexpr double kSlideTolerance = 0.03;
// Angular momentum about a line in the floor is kept at any friction. The remaining error is that of the radius, by the
// gap of the contact: 0.1 mm of 50 mm.
constexpr double kRollTolerance = 2e-3;
// Of a steady motion; the gap of the contact makes the arm of friction longer by 0.2 %.
constexpr double kSlipTolerance = 0.01;

struct Slid {
  double distance, acceleration;
};

// A block on a slope of `angle` that falls along `azimuth`, from 0.2 s, when it has settled, to 1 s.
Slid slide(Suite& s, double angle, double azimuth) {
  const Quat slope = tilt(angle, azimuth);
  const Vec3 half(0.05, 0.05, 0.02), down = slope * Vec3(std::cos(azimuth), std::sin(azimuth), 0.0);
  RigidBody block = at(box(2, half), slope * Vec3(0, 0, half.z()));
  block.motion.orientation = slope;
  Play play(s.target, {{{half_space(1, slope), block}, law(kMu, 0.0), {}}, gravity()});
  play.run(0.2);
  const BodyMotion start = play.body(2).motion;
  play.run(0.8);
  const BodyMotion end = play.body(2).motion;
  play.end();
  return {(end.position - start.position).dot(down), (end.velocity - start.velocity).dot(down) / 0.8};
}

void incline(Suite& s) {
  for (const double azimuth_deg : {0.0, 30.0}) {  // a friction pyramid instead of a cone fails one of them
    const double azimuth = azimuth_deg * EIGEN_PI / 180.0;
    s.report.check(fmt::format("holds_{:g}deg", azimuth_deg), slide(s, std::atan(0.9 * kMu), azimuth).distance, 0.0,
                   kCreep_m, "slip [m] at 0.9 of the friction angle's tangent");
    const double angle = std::atan(1.1 * kMu);
    s.report.check(fmt::format("slides_{:g}deg", azimuth_deg), slide(s, angle, azimuth).acceleration,
                   kGravity * (std::sin(angle) - kMu * std::cos(angle)), kSlideTolerance,
                   "acceleration [m/s^2] at 1.1 of it");
  }
}

void roll(Suite& s) {
  constexpr double radius = 0.05, speed = 1.0, friction = 0.3;
  const RigidBody ball = moving(at(sphere(2, radius), {0, 0, radius}), {0.8 * speed, 0.6 * speed, 0});
  Play play(s.target, {{{half_space(1), ball}, law(friction, 0.0), {}}, gravity()});
  play.run(1.5 * 2.0 / 7.0 * speed / (friction * kGravity));  // 1.5 times the time of sliding
  const RigidBody& b = play.body(2);
  const Vec3 slip = b.motion.velocity + b.angular_velocity().cross(Vec3(0, 0, -radius));
  s.report.check("speed", b.motion.velocity.norm() / speed, 5.0 / 7.0, kRollTolerance);
  s.report.check("slip", slip.head<2>().norm() / speed, 0.0, kRollTolerance,
                 "of the lowest point, relative to the first speed");
  play.end();
}

// A sphere rolls down a slope without slip as long as tan(angle) <= 7/2 friction. This one is steeper, so friction is
// at its bound all the way, and takes the slope's own normal.
void slip(Suite& s) {
  constexpr double radius = 0.05, friction = 0.3, azimuth = 30.0 * EIGEN_PI / 180.0, angle = 55.0 * EIGEN_PI / 180.0;
  const Quat slope = tilt(angle, azimuth);
  const Vec3 down = slope * Vec3(std::cos(azimuth), std::sin(azimuth), 0.0), normal = slope * Vec3::UnitZ();
  Play play(s.target,
            {{{half_space(1, slope), at(sphere(2, radius), radius * normal)}, law(friction, 0.0), {}}, gravity()});
  play.run(0.1);
  const RigidBody start = play.body(2);
  play.run(0.2);
  const RigidBody end = play.body(2);
  play.end();
  s.report.check("acceleration", (end.motion.velocity - start.motion.velocity).dot(down) / 0.2,
                 kGravity * (std::sin(angle) - friction * std::cos(angle)), kSlipTolerance, "along the slope [m/s^2]");
  s.report.check("spin", (end.angular_velocity() - start.angular_velocity()).dot(normal.cross(down)) * radius / 0.2,
                 2.5 * friction * kGravity * std::cos(angle), kSlipTolerance,
                 "angular acceleration times the radius [m/s^2]: by friction alone");
}

}  // namespace

std::vector<Case> friction_cases() {
  return {
      {"friction_angle", "a block on a slope holds and slides", {kBoxes, kHalfSpaces, kContact, kFriction}, incline},
      {"rolling",
       "a sliding sphere comes to roll with 5/7 of its speed",
       {kSpheres, kHalfSpaces, kContact, kFriction},
       roll},
      {"slipping",
       "a sphere slips down a steep slope, whose friction spins it",
       {kSpheres, kHalfSpaces, kContact, kFriction},
       slip},
  };
}

}  // namespace sunder::conformance
