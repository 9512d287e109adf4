// Collisions of free bodies: momentum is kept, energy does not grow, restitution follows the law.
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "tests/conformance/shift.h"
#include "tests/conformance/suite.h"

namespace sunder::conformance {
namespace {

using namespace link::capability;

// An engine applies each impulse to both bodies at one point. So momentum closes to the round-off of some dozens of
// additions, whatever the convergence of the solver. shift.h says which part of angular momentum closes as well.
constexpr double kCollisionMomentum = 1e-12;
// A correct impulse adds round-off only. 1e-9 of the kinetic energy is a thousand times that.
constexpr double kGainTolerance = 1e-9;
// With restitution 1 the rebound has the speed of the impact. Two to four points solved by iteration err by some tenths
// of a percent.
constexpr double kElasticTolerance = 1e-2;
constexpr double kRestitutionTolerance = 1e-2;
// Shapes are true to 0.1 mm, a twentieth of the 2 mm that a body flies in a window. The way back shifts as the way
// there.
constexpr double kPlaceTolerance = 0.05;
// Least share of the relative momentum that a collision passes on.
constexpr double kMet = 0.1;

RigidBody angle_iron(BodyId id) {  // an L of two convex parts
  return plate(id, {rectangle(0, 0, 0.1, 0.03), rectangle(0, 0.03, 0.03, 0.1)}, 0.02);
}

constexpr double kWindow_s = 1e-3;

struct Meeting {
  RigidBody first, second;
  double friction, restitution;
};

Meeting spheres(const Vec3& offset, double friction, double restitution, const Vec3& spin) {
  return {moving(at(sphere(1, 0.05), Vec3(-0.1, 0, 0)), {1.0, 0, 0}, spin),
          moving(at(sphere(2, 0.04), offset), {-0.6, 0, 0}, -0.5 * spin), friction, restitution};
}

Meeting boxes(const Vec3& offset, double friction, double restitution) {
  return {moving(turned(at(box(1, {0.05, 0.03, 0.02}), {-0.15, 0, 0}), {0.3, 0.5, 0.2}), {1.5, 0, 0.1}, {2, 1, -3}),
          moving(at(box(2, {0.04, 0.04, 0.06}), offset), {-0.5, 0.1, 0}, {0, 1, 1}), friction, restitution};
}

Meeting compounds(double friction) {
  return {moving(turned(at(angle_iron(1), {-0.15, 0, 0}), {0.8, 0.2, 0.4}), {1.5, 0.1, 0}, {2, 1, -3}),
          moving(turned(at(angle_iron(2), {0, 0.02, 0.02}), {0.1, -0.9, 0}), {-0.5, 0, 0}, {1, 0, 1}), friction, 0.0};
}

// Farthest surface point from the centre of a colliding body.
constexpr double kReach_m = 0.1;

void meet(Suite& s, const Meeting& m) {
  Play play(s.target, {{{m.first, m.second}, law(m.friction, m.restitution), {}}, Vec3::Zero(), kWindow_s});
  const Vec3 linear = play.momentum();
  const double start = play.kinetic_energy();
  const double reduced = m.first.mass * m.second.mass / (m.first.mass + m.second.mass);
  const double relative = reduced * (m.first.motion.velocity - m.second.motion.velocity).norm();
  const double arm = (m.first.motion.position - m.second.motion.position).norm();
  ShiftRows angular(play, kWindow_s, kReach_m);
  double gain = 0.0;
  for (int i = 0; i < 300; ++i) {
    angular.before(play);
    play.window();
    angular.after(play);
    gain = std::max(gain, (play.kinetic_energy() - play.predicted_energy()) / start);  // flight has its own error
  }
  const Vec3 change = m.first.mass * (play.body(1).motion.velocity - m.first.motion.velocity);
  const double met = change.norm() / relative;
  s.report.check_error("met", met, kMet, std::max(0.0, kMet - met), 0.0,
                       "share of the relative momentum that is passed on");
  s.report.check("linear", (play.momentum() - linear).norm() / relative, 0.0, s.exact(kCollisionMomentum));
  angular.judge(play, s.report, relative * arm, s.exact(kCollisionMomentum));
  if (m.restitution < 1.0)
    s.report.check("gain", gain, 0.0, s.exact(kGainTolerance),
                   "largest gain in a window, relative to the kinetic energy");
  else
    s.report.check("energy", play.kinetic_energy(), start, kElasticTolerance);
  play.end();
}

// Head-on impact at 2 m/s without gravity: ratio of the rebound speed, and place. The gap kGap_m is no whole number of
// windows. An engine goes on from the touch for the rest of its window. One that resolves a rebound at the window's
// begin puts the body ahead, by its way there and back before the touch. One that does so at its end makes it late, by
// its way back after the touch. No engine may be further off than these two.
constexpr double kGap_m = 0.0433, kFlight_s = 0.1;
void bounce(Suite& s, const RigidBody& lower, const RigidBody& upper, double half_width) {
  for (const double restitution : {0.0, 0.5, 1.0}) {
    Play play(s.target, {{{lower, moving(upper, {0, 0, -2.0})}, law(0.0, restitution), {}}, Vec3::Zero(), kWindow_s});
    play.run(kFlight_s);
    const BodyMotion& up = play.body(upper.id).motion;
    const double measured = (up.velocity - play.body(lower.id).motion.velocity).z() / 2.0;
    const double turn = play.body(upper.id).angular_velocity().norm() * half_width / 2.0;
    s.report.check_error(fmt::format("e_{:g}", restitution), measured, restitution, std::abs(measured - restitution),
                         kRestitutionTolerance, "absolute");
    s.report.check(fmt::format("turn_{:g}", restitution), turn, 0.0, kRestitutionTolerance,
                   "speed of its rim, relative to the closing speed");
    if (restitution > 0.0) {
      const double apart = (up.position - play.body(lower.id).motion.position).z() -
                           (upper.motion.position - lower.motion.position).z() + kGap_m;
      const double flown = measured * 2.0 * (kFlight_s - kGap_m / 2.0);
      const double ahead = (apart - flown) / ((1.0 + restitution) * 2.0 * kWindow_s);
      const double before = std::fmod(kGap_m / 2.0 / kWindow_s, 1.0);  // the touch [of a window]
      const double least = -restitution / (1.0 + restitution) * (1.0 - before);
      const double off = std::isfinite(ahead) ? std::max({0.0, ahead - before, least - ahead}) : ahead;
      s.report.check_error(fmt::format("ahead_{:g}", restitution), ahead, 0.0, std::abs(ahead), kPlaceTolerance,
                           "its place, in ways there and back of a window");
      s.report.check_error(fmt::format("within_{:g}", restitution), ahead, 0.0, off, kPlaceTolerance,
                           fmt::format("the same: {:.2f} at a window's end to {:.2f} at its begin", least, before));
    }
    play.end();
  }
}

// An elastic sphere flies between two walls, with less room than it flies in a window and with more. An engine that
// lets it go on from a touch must see what stands behind it.
constexpr double kInsideTolerance_m = 1e-4;  // shapes are true to that (rest_*)
void bounce_between(Suite& s) {
  double inside = 0.0, off = 0.0;
  for (const double room : {0.37e-3, 1.7e-3, 3e-3}) {
    const auto wall = [&](BodyId id, double x) { return fixed(at(box(id, {0.01, 0.2, 0.2}), {x, 0, 0})); };
    const double left = -0.05 - 0.3 * room, right = 0.05 + 0.7 * room;
    Play play(s.target,
              {{{wall(1, left - 0.01), moving(sphere(2, 0.05), {2.0, 0, 0}), wall(3, right + 0.01)}, law(0.0, 1.0), {}},
               Vec3::Zero(),
               kWindow_s});
    for (int i = 0; i < 100; ++i) {
      play.window();
      const BodyMotion& now = play.body(2).motion;
      inside = std::max({inside, left + 0.05 - now.position.x(), now.position.x() - right + 0.05});
      const double error = std::abs(now.velocity.norm() / 2.0 - 1.0);
      if (!(error <= off)) off = error;
    }
    play.end();
  }
  s.report.check("inside", inside, 0.0, kInsideTolerance_m, "greatest depth in a wall [m]");
  s.report.check("speed", off, 0.0, kElasticTolerance, "greatest change, relative");
}

// Two spheres of unequal size meet off their centres without friction. They touch where they are as far apart as their
// radii say, exchange (1 + e) of the closing speed along the line of centres, and fly on. An engine that takes the
// normal or the point of another moment turns them, or is late.
void bounce_oblique(Suite& s) {
  for (const double restitution : {0.5, 1.0}) {
    const double large = 0.05, small = 0.02;
    const RigidBody a = moving(sphere(1, large), {0.8, 2.0, 0}),
                    b = moving(at(sphere(2, small), {0.0888, 0.0345, 0.011}), {-1.2, -1.0, 0.2});
    const Vec3 d = b.motion.position - a.motion.position, v = b.motion.velocity - a.motion.velocity;
    const double vv = v.squaredNorm(), dv = d.dot(v), over = d.squaredNorm() - (large + small) * (large + small);
    const double touch = (-dv - std::sqrt(dv * dv - vv * over)) / vv;
    const Vec3 n = (d + touch * v).normalized();
    const double closing = -v.dot(n), impulse = (1.0 + restitution) * closing / (1.0 / a.mass + 1.0 / b.mass);
    Play play(s.target, {{{a, b}, law(0.0, restitution), {}}, Vec3::Zero(), kWindow_s});
    constexpr double kTime_s = 0.03;
    play.run(kTime_s);
    double place = 0.0, rim = 0.0;
    for (const auto& [body, sign, radius] : {std::tuple(&a, -1.0, large), std::tuple(&b, 1.0, small)}) {
      const Vec3 change = sign * impulse / body->mass * n;
      const Vec3 there = body->motion.position + kTime_s * body->motion.velocity + (kTime_s - touch) * change;
      place = std::max(place, (play.body(body->id).motion.position - there).norm() / (change.norm() * kWindow_s));
      rim = std::max(rim, play.body(body->id).angular_velocity().norm() * radius / closing);
    }
    s.report.check_error(fmt::format("place_{:g}", restitution), place, 0.0, place, kPlaceTolerance,
                         "the farther one's, in ways that the impact changes in a window");
    s.report.check(fmt::format("turn_{:g}", restitution), rim, 0.0, kRestitutionTolerance,
                   "speed of its rim, relative to the closing speed");
    play.end();
  }
}

// A rod comes down on one end. The impact turns it, so that the other end comes down faster than the rod did.
void bounce_tilted(Suite& s) {
  const Vec3 half(0.1, 0.01, 0.01);
  double deepest = 0.0;
  for (const double restitution : {0.5, 1.0})
    for (const double tilt : {0.0045, 0.02}) {
      Play play(s.target,
                {{{half_space(1), moving(turned(at(box(2, half), {0, 0, 0.0135}), {0, tilt, 0}), {0, 0, -2.0})},
                  law(0.0, restitution),
                  {}},
                 Vec3::Zero(),
                 kWindow_s});
      for (int i = 0; i < 40; ++i) {
        play.window();
        const BodyMotion& m = play.body(2).motion;
        for (const double x : {-1.0, 1.0})
          for (const double y : {-1.0, 1.0})
            for (const double z : {-1.0, 1.0})
              deepest = std::max(deepest, -(m.position + m.orientation * half.cwiseProduct(Vec3(x, y, z))).z());
      }
      play.end();
    }
  s.report.check("inside", deepest, 0.0, kInsideTolerance_m, "greatest depth in the floor [m]");
}

// Spheres fall beside two that touch and have the lowest and highest id. An engine that solves groups of touching
// bodies separately must find each group in every solve.
void bounce_beside(Suite& s) {
  for (const double restitution : {0.0, 0.5, 1.0}) {
    std::vector<RigidBody> bodies{half_space(1), at(sphere(2, 0.05), {0, 0, 1.0}), at(sphere(9, 0.05), {0.1, 0, 1.0})};
    for (BodyId id = 3; id < 7; ++id)
      bodies.push_back(moving(at(sphere(id, 0.05), {0.5 * id, 0, 0.0933 + 0.01 * id}), {0, 0, -2.0}));
    std::sort(bodies.begin(), bodies.end(), [](const RigidBody& a, const RigidBody& b) { return a.id < b.id; });
    Play play(s.target, {{std::move(bodies), law(0.0, restitution), {}}});
    play.run(0.1);
    double measured = restitution;
    for (BodyId id = 3; id < 7; ++id) {
      const double own = play.body(id).motion.velocity.z() / 2.0;
      if (!(std::abs(own - restitution) <= std::abs(measured - restitution))) measured = own;
    }
    s.report.check_error(fmt::format("e_{:g}", restitution), measured, restitution, std::abs(measured - restitution),
                         kRestitutionTolerance, "the worst of four, absolute");
    play.end();
  }
}

}  // namespace

std::vector<Case> collision_cases() {
  const auto one = [](const std::string& name, const std::string& what, std::vector<std::string> needs, Meeting m) {
    needs.push_back(kContact);
    if (m.friction > 0.0) needs.push_back(kFriction);
    if (m.restitution > 0.0) needs.push_back(kRestitution);
    return Case{"collision_" + name, what, std::move(needs), [m = std::move(m)](Suite& s) { meet(s, m); }};
  };
  const Vec3 centre(0.05, 0, 0), beside(0.05, 0.03, 0.02), near(0.02, 0.03, 0.01);
  return {
      one("spheres", "two spheres, head-on", {kSpheres}, spheres(centre, 0, 0, Vec3::Zero())),
      one("spheres_off_centre", "two spheres, off-centre", {kSpheres}, spheres(beside, 0, 0.3, Vec3::Zero())),
      one("spheres_frictional", "two spinning spheres with friction", {kSpheres},
          spheres(beside, 0.4, 0, {5, 20, -30})),
      one("spheres_elastic", "two elastic spheres", {kSpheres}, spheres(beside, 0, 1, {5, 0, 3})),
      one("boxes_off_centre", "two tumbling boxes", {kBoxes}, boxes(near, 0, 0)),
      one("boxes_frictional", "two tumbling boxes with friction", {kBoxes}, boxes(near, 0.4, 0)),
      one("boxes_elastic", "two elastic boxes", {kBoxes}, boxes(near, 0, 1)),
      one("compounds", "two L of two parts", {kConvexHulls, kCompound}, compounds(0)),
      one("compounds_frictional", "two L with friction", {kConvexHulls, kCompound}, compounds(0.4)),
  };
}

std::vector<Case> restitution_cases() {
  return {
      {"restitution_sphere_floor",
       "restitution 0, 0.5, 1 of a sphere on a half space",
       {kSpheres, kHalfSpaces, kContact, kRestitution},
       [](Suite& s) {
         bounce(s, half_space(1), at(sphere(2, 0.05), {0, 0, 0.0933}), 0.05);
       }},
      {"restitution_beside_others",
       "the same of four, beside two that touch one another",
       {kSpheres, kHalfSpaces, kContact, kRestitution},
       [](Suite& s) { bounce_beside(s); }},
      {"restitution_between_walls",
       "an elastic sphere between two near walls",
       {kSpheres, kBoxes, kContact, kRestitution},
       [](Suite& s) { bounce_between(s); }},
      {"restitution_spheres",
       "the same of two spheres",
       {kSpheres, kContact, kRestitution},
       [](Suite& s) {
         bounce(s, sphere(1, 0.05), at(sphere(2, 0.05), {0, 0, 0.1433}), 0.05);
       }},
      {"restitution_oblique",
       "two unequal spheres that meet off their centres",
       {kSpheres, kContact, kRestitution},
       [](Suite& s) { bounce_oblique(s); }},
      {"restitution_tilted",
       "a rod that comes down on one end",
       {kBoxes, kHalfSpaces, kContact, kRestitution},
       [](Suite& s) { bounce_tilted(s); }},
      {"restitution_box_floor",
       "the same of a box that comes down flat",
       {kBoxes, kHalfSpaces, kContact, kRestitution},
       [](Suite& s) {
         bounce(s, half_space(1), at(box(2, {0.05, 0.04, 0.02}), {0, 0, 0.0633}), 0.05);
       }},
  };
}

}  // namespace sunder::conformance
