#include "rigid/engine/at_touch.h"

#include <algorithm>
#include <variant>

namespace sunder::rigid {
namespace {

constexpr int kNewtonSteps = 8;  // of Newton's method, whose error squares in each

const SphereShape* ball(const RigidBody& body) { return std::get_if<SphereShape>(&body.shape); }

}  // namespace

RigidBody before_end(const RigidBody& body, const BodyMotion& predicted, const Vec3& pull, double rest) {
  RigidBody then = body;
  then.motion = predicted;
  then.motion = flown_on(then, pull, -rest);
  return then;
}

BodyMotion flown_on(RigidBody body, const Vec3& pull, double rest) {
  body.drift(rest);
  body.motion.position += 0.5 * rest * rest * pull;
  body.motion.velocity += rest * pull;
  return body.motion;
}

Shift shift_between(const BodyMotion& from, const BodyMotion& to) {
  return {to.position - from.position, rotation_vector(to.orientation * from.orientation.conjugate())};
}

std::optional<double> touch_time(const Flight& first, const Flight& second, double window_s, double allowance,
                                 double guess) {
  const SphereShape *one = ball(*first.body), *other = ball(*second.body);
  if (!one || !other) return guess;
  const double wanted = one->radius + other->radius - allowance;
  const Vec3 apart_at_end = first.predicted->position - second.predicted->position;
  const Vec3 speed_at_end = first.predicted->velocity - second.predicted->velocity, pull = first.pull - second.pull;
  double touch = guess;
  for (int step = 0; step < kNewtonSteps; ++step) {
    const double rest = window_s - touch;
    const Vec3 apart = apart_at_end - rest * speed_at_end + 0.5 * rest * rest * pull;
    const double distance = apart.norm(), opening = apart.dot(speed_at_end - rest * pull) / distance;
    if (touch == 0.0 && distance <= wanted) return touch;  // they overlap from the start
    if (!(opening < 0.0)) return {};
    const double next = std::max(0.0, touch - (distance - wanted) / opening);
    if (next > window_s) return {};
    if (next == touch) break;
    touch = next;
  }
  return touch;
}

Vec3 normal_at_touch(const RigidBody& first, const RigidBody& second, const Vec3& before) {
  if (!ball(first) || !ball(second)) return before;
  return (first.motion.position - second.motion.position).normalized();
}

}  // namespace sunder::rigid
