#pragma once
// Principal values and directions of a plane stress.
#include <cmath>

#include "coupler/core/vec.h"

namespace sunder::shell {

/// `d` rotated counterclockwise by `angle` [rad].
inline Vec2 turned(const Vec2& d, double angle) {
  return {std::cos(angle) * d.x() - std::sin(angle) * d.y(), std::sin(angle) * d.x() + std::cos(angle) * d.y()};
}

struct Principal {
  double high, low;
  Vec2 crack;  // direction of a crack that the higher stress opens
};
inline Principal principal(double s11, double s22, double s12) {
  const double mean = 0.5 * (s11 + s22), half = 0.5 * (s11 - s22), radius = std::hypot(half, s12);
  const double angle = 0.5 * std::atan2(s12, half);
  return {mean + radius, mean - radius, Vec2(-std::sin(angle), std::cos(angle))};
}

}  // namespace sunder::shell
