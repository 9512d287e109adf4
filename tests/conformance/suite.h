#pragma once
// The cases and their arguments.
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "tests/conformance/bodies.h"
#include "tests/conformance/play.h"
#include "tests/conformance/report.h"

namespace sunder::conformance {

/// The engine under test, and the report.
struct Suite {
  Target target;
  link::EngineInfo info;
  Report report;

  /// Tolerance of a quantity that is exact up to round-off. It is `tolerance` for an engine in double precision. Single
  /// precision keeps seven digits, and sums and differences of a window lose up to three of them.
  double exact(double tolerance) const { return info.can(link::capability::kDoublePrecision) ? tolerance : 1e-4; }
};

/// A case of the suite.
struct Case {
  std::string name, what;
  std::vector<std::string> needs;  // capabilities; an engine that does not declare all of them skips the case
  std::function<void(Suite&)> run;
};

/// Rotation from z to the normal of a plane that falls at `angle` along `azimuth` in the xy plane [rad].
inline Quat tilt(double angle_rad, double azimuth_rad) {
  return rotation_from_vector(angle_rad * Vec3(-std::sin(azimuth_rad), std::cos(azimuth_rad), 0.0));
}

constexpr double kGravity = 9.81;  // [m/s^2]
inline Vec3 gravity() { return {0.0, 0.0, -kGravity}; }

/// One law for all bodies, in contact group 0.
inline std::vector<ContactLaw> law(double friction, double restitution) { return {{0, 0, friction, restitution}}; }

std::vector<Case> flight_cases();
std::vector<Case> collision_cases();
std::vector<Case> restitution_cases();
std::vector<Case> friction_cases();
std::vector<Case> joint_cases();
std::vector<Case> resting_cases();
std::vector<Case> tunnelling_cases();
std::vector<Case> birth_cases();
std::vector<Case> repeat_cases();
std::vector<Case> export_cases();
std::vector<Case> rule_cases();
std::vector<Case> cost_cases();

}  // namespace sunder::conformance
