// Bodies without contacts: each window ends in the predicted state, and the angular momentum stays.
#include <algorithm>

#include "tests/conformance/shift.h"
#include "tests/conformance/suite.h"

namespace sunder::conformance {
namespace {

using namespace link::capability;

constexpr int kWindows = 10000;
// An engine may hold positions in its own units, in double precision. This costs some round-offs of 1e-16 a window,
// which do not add up, because each predicted state is new. 1e-9 allows for conversion to a rotation matrix and back.
constexpr double kFlightTolerance = 1e-9;
// Angular momentum is that of the predicted state; as above.
constexpr double kSpinTolerance = 1e-9;
// The two impulses of a contact are equal and opposite to round-off, whatever the convergence of the solver.
constexpr double kMomentumTolerance = 1e-12;

void fly_freely(Suite& s, const RigidBody& body, double size) {
  Play play(s.target, {{{moving(body, {1.5, -0.7, 20.0}, {7.0, -3.0, 5.0})}, {}, {}}, gravity()});
  double pose = pose_error(play.states()[0].motion, play.body(1).motion, size), velocity = 0.0;
  int exact = 0;
  for (int i = 0; i < kWindows; ++i) {
    play.window();
    const BodyMotion &got = play.states()[0].motion, &given = play.predicted()[0].motion;
    pose = std::max(pose, pose_error(got, given, size)), velocity = std::max(velocity, velocity_error(got, given));
    exact += same_bits(got, given);
  }
  const std::string note = exact == kWindows ? "bit-exact" : fmt::format("bit-exact in {} windows", exact);
  s.report.check("pose", pose, 0.0, s.exact(kFlightTolerance), note);
  s.report.check("velocity", velocity, 0.0, s.exact(kFlightTolerance), note);
  s.report.check("mass", play.states()[0].mass, body.mass, s.exact(kMomentumTolerance));
  play.end();
}

RigidBody half_metre_shard(BodyId id) {
  return plate(id, {{{0.0, 0.0}, {0.5, 0.05}, {0.42, 0.3}, {0.1, 0.22}}}, 0.003);
}

RigidBody splinter(BodyId id, const Vec3& size) { return plate(id, {rectangle(0, 0, size.x(), size.y())}, size.z()); }

void spin_freely(Suite& s, const Vec3& size) {
  const RigidBody shard = moving(at(splinter(1, size), Vec3(0, 0, 1)), {0.1, 0, 0}, {40.0, 25.0, 60.0});
  Play play(s.target, {{{shard}, {}, {}}});
  play.run(1.0);
  const BodyMotion& end = play.body(1).motion;
  const Vec3& spin = shard.motion.angular_momentum;
  s.report.check("spin", (end.angular_momentum - spin).norm() / spin.norm(), 0.0, s.exact(kSpinTolerance),
                 "after 1000 windows of 1 ms");
  play.end();
}

// A splinter hits a second one off its centre, at 15 thicknesses a second. Both leave spinning.
void spin_after_collision(Suite& s, const Vec3& size) {
  const double window_s = 5e-4;
  const double speed = std::max(0.2, 15.0 * size.z());  // fast enough to bounce
  const RigidBody still = at(splinter(1, size), Vec3::Zero());
  const RigidBody thrown =
      moving(at(splinter(2, size), Vec3(0.35 * size.x(), 0.3 * size.y(), 3.0 * size.z())), {0, 0, -speed}, {1, 2, -3});
  Play play(s.target, {{{still, thrown}, law(0.0, 0.5), {}}, Vec3::Zero(), window_s});
  const Vec3 linear = play.momentum();
  ShiftRows angular(play, window_s, size.x());
  const double push = thrown.mass * speed, turn = push * size.x();
  // at the end they are several lengths apart
  for (long i = std::lround(12.0 * size.x() / speed / window_s); i > 0; --i) {
    angular.before(play);
    play.window();
    angular.after(play);
  }
  const double apart = (play.body(1).motion.position - play.body(2).motion.position).norm();
  const Vec3 spins[] = {play.body(1).motion.angular_momentum, play.body(2).motion.angular_momentum};
  play.run(0.5);
  const double met = play.body(1).mass * play.body(1).motion.velocity.norm() / push;
  s.report.check_error("met", met, 0.1, std::max(0.0, 0.1 - met), 0.0, "share of the momentum that was passed on");
  s.report.check("linear", (play.momentum() - linear).norm() / push, 0.0, s.exact(kMomentumTolerance));
  angular.judge(play, s.report, turn, s.exact(kMomentumTolerance));
  for (const BodyId id : {1, 2}) {
    const Vec3& before = spins[id - 1];
    const double error =
        apart > size.x() ? (play.body(id).motion.angular_momentum - before).norm() / before.norm() : NAN;
    s.report.check(fmt::format("spin_{}", id), error, 0.0, s.exact(kSpinTolerance), "over 1000 windows once apart");
  }
  play.end();
}

}  // namespace

std::vector<Case> flight_cases() {
  const Vec3 twenty(0.02, 0.015, 0.002), two(0.002, 0.0015, 0.0005);
  return {
      {"free_flight_sphere",
       "10000 windows end in the predicted state",
       {kSpheres},
       [](Suite& s) { fly_freely(s, sphere(1, 0.05), 0.05); }},
      {"free_flight_box",
       "a tumbling box ends in the predicted state",
       {kBoxes},
       [](Suite& s) {
         fly_freely(s, box(1, {0.1, 0.05, 0.02}), 0.1);
       }},
      {"free_flight_shard",
       "half a metre of glass ends in the predicted state",
       {kConvexHulls},
       [](Suite& s) { fly_freely(s, half_metre_shard(1), 0.5); }},
      {"splinter_20mm", "a splinter keeps its spin", {kConvexHulls}, [=](Suite& s) { spin_freely(s, twenty); }},
      {"splinter_2mm", "a small splinter keeps its spin", {kConvexHulls}, [=](Suite& s) { spin_freely(s, two); }},
      {"splinter_20mm_struck",
       "splinters keep momentum and spin after a collision",
       {kConvexHulls, kContact},
       [=](Suite& s) { spin_after_collision(s, twenty); }},
      {"splinter_2mm_struck",
       "the same for small ones",
       {kConvexHulls, kContact},
       [=](Suite& s) { spin_after_collision(s, two); }},
  };
}

}  // namespace sunder::conformance
