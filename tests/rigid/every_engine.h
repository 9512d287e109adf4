#pragma once
// Engines of this project whose promises are the same, and how near each comes to them.
#include <memory>
#include <ostream>
#include <string>

#include <gtest/gtest.h>

#include "tests/rigid/trial.h"

namespace sunder::rigid::testing {

struct EngineLimits {
  const char *name, *version;  // of which its version begins
  double apart;                // of two plates of 3 mm, from middle to middle, that leave one another alone [m]
  double solved;               // residual of a collision [m/s]
  double gap;                  // off the place of a body at rest [m]
  double still;                // speed of a body at rest [m/s]
  double jump;                 // energy that moving out of an overlap gives in a window [J]
  double sunk;                 // depth of a corner at its impact [m]
  double hull;                 // off the size of a shape [m]
};
inline void PrintTo(const EngineLimits& limits, std::ostream* out) { *out << limits.name; }

/// Bullet keeps a margin about hulls, computes them on a grid of 2 um, and leaves bodies at rest with a window's speed
/// of gravity. It moves poses out of overlaps by 10 um at a time.
inline constexpr EngineLimits kBullet{"bullet", "3.", 0.03, 1e-9, 1e-5, kGravity* Trial::kWindow, 1e-4, 1e-3, 2e-6};
/// ODE solves exactly what is small, with a softness of 1e-9 of the change. Its look-ahead follows tangents of corners.
inline constexpr EngineLimits kOde{"ode", "0.16", 0.0035, 1e-7, 1e-6, 1e-6, 1e-6, 0.3e-3, 1e-6};

class EveryEngine : public ::testing::TestWithParam<EngineLimits> {
 protected:
  static constexpr double kWindow = Trial::kWindow;
  static std::unique_ptr<Engine> make() { return make_engine(GetParam().name); }
};
inline std::string name_of(const ::testing::TestParamInfo<EngineLimits>& info) { return info.param.name; }

inline RigidBody small_shard(BodyId id) {
  return plate(id, {{Vec2(0, 0), Vec2(0.02, 0.003), Vec2(0.007, 0.013)}}, 0.003);
}

}  // namespace sunder::rigid::testing
