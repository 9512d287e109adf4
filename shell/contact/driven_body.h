#pragma once
// Bodies whose motion the scene prescribes: poses over time, and shapes over time. Nothing changes their motion.
#include <memory>
#include <vector>

#include "coupler/core/body.h"
#include "coupler/core/pose_curve.h"

namespace sunder::shell {

/// Shapes of a surface over time: corners at each key and their slopes [m], [m/s], in body axes.
struct ShapeCurve {
  std::vector<double> times;  // [s]
  std::vector<std::vector<Vec3>> corners, slopes;

  bool empty() const { return times.empty(); }
  /// Corners at time t.
  void at(double t, std::vector<Vec3>& out) const;
};

/// Shapes at keys, with smooth slopes.
ShapeCurve shape_curve(std::vector<double> times, std::vector<std::vector<Vec3>> corners);

/// The motion of a body as the scene gives it.
struct DrivenMotion {
  PoseCurve path;          // of the body's frame in the scene; empty: it stays at `still`
  PlacedAt still;          // pose of that frame, where the path is empty
  PlacedAt own;            // centre and axes of the body in that frame
  ShapeCurve shape;        // empty: the body is rigid
  double top_speed = 0.0;  // largest speed of any of its points over the whole motion [m/s]

  bool deforms() const { return !shape.empty(); }
  /// Pose of the body's centre and axes at time t [s].
  PlacedAt at(double t) const;
  /// Time of the last key [s].
  double last() const;
  /// Speed of the fastest point of the body [m/s]: the largest mean over a share of the time between two keys. `radius`
  /// [m] holds a rigid body about its centre. `when` is set to the time of the fastest one [s].
  double fastest(double radius, double& when) const;
};

/// Sets centre, axes and velocities of a body to those of its motion: the pose at time t [s], and the constant velocity
/// and spin that lead to the pose at t + dt. dt 0: at rest.
void place(const DrivenMotion& motion, double t, double dt, RigidBody& body, Vec3& spin);

}  // namespace sunder::shell
