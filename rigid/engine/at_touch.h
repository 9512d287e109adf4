#pragma once
// Two moving bodies at their touch within a window. Solved there, a rebound keeps their angular momentum: at the
// window's end their tangential motion has carried them on, and the same impulse would turn the pair.
#include <optional>

#include "coupler/core/body.h"
#include "rigid/engine/way_back.h"

namespace sunder::rigid {

/// The body `rest` seconds before the end of a window, flown back from its predicted motion. `pull`: its mean
/// acceleration [m/s^2].
RigidBody before_end(const RigidBody& body, const BodyMotion& predicted, const Vec3& pull, double rest);

/// The motion after another `rest` seconds of flight.
BodyMotion flown_on(RigidBody body, const Vec3& pull, double rest);

/// Translation and turn from a pose to another one.
Shift shift_between(const BodyMotion& from, const BodyMotion& to);

/// A moving body in a window: `pull` is the mean acceleration that leads to its predicted motion [m/s^2].
struct Flight {
  const RigidBody* body;
  const BodyMotion* predicted;
  Vec3 pull;
};

/// When two balls touch [s since the window's begin], from a first guess along the normal at its start; none where they
/// pass one another, or touch after the window. Other shapes: the guess. They may keep an overlap of `allowance` [m].
std::optional<double> touch_time(const Flight& first, const Flight& second, double window_s, double allowance,
                                 double guess);

/// The normal at the touch, from the second body to the first: that of two balls goes through their centres, any other
/// stays `before`.
Vec3 normal_at_touch(const RigidBody& first, const RigidBody& second, const Vec3& before);

}  // namespace sunder::rigid
