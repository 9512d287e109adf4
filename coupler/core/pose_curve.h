#pragma once
// A prescribed motion: poses at times, and a smooth path through them.
#include <optional>
#include <vector>

#include "coupler/core/smooth_keys.h"
#include "coupler/core/vec.h"

namespace sunder {

/// Where something is, and how it is turned.
struct PlacedAt {
  Vec3 position = Vec3::Zero();         // [m]
  Quat orientation = Quat::Identity();  // to world
};

/// A pose that is given. A turn is a rotation vector [rad], the axis times an angle, which may be above pi.
struct PoseKey {
  double time = 0.0;  // [s]
  Vec3 position = Vec3::Zero();
  Vec3 turn = Vec3::Zero();
  bool counts_turns = true;            // false: the turn is known but for whole turns, as that of a quaternion
  std::optional<Vec3> velocity, spin;  // [m/s], [rad/s] in world axes; absent: smooth, and at rest at both ends
};

/// Positions are cubic in time between keys. Orientations are q(t) = exp(h(t)) q_k, with a rotation vector h(t) that is
/// cubic in time: it starts at zero with the slope w_k and ends at r with the slope J(r)^-1 w_(k+1), J being the left
/// Jacobian of the rotation group. Velocity and spin are continuous. r is the shortest turn to the next key. Where both
/// keys count turns about one axis it is the difference of their angles, so that a body may turn more than once.
class PoseCurve {
 public:
  PoseCurve() = default;
  explicit PoseCurve(const std::vector<PoseKey>& keys);
  bool empty() const { return times_.empty(); }
  const std::vector<double>& times() const { return times_; }  // of the keys [s]
  PlacedAt at(double t) const;
  /// At least the angle [rad] that it turns through from time t to time u, between which there is no key; whole turns
  /// count. It is that angle where the axis stays.
  double turning(double t, double u) const;

 private:
  Vec3 turned(const HermiteWeights& w) const;  // h, between a key and the next one

  std::vector<double> times_;
  std::vector<Vec3> positions_, velocities_;
  std::vector<Quat> orientations_;
  std::vector<Vec3> turns_;                  // from each key to the next [rad]
  std::vector<Vec3> turn_from_, turn_into_;  // slope of h at both ends of each piece [rad/s]
};

}  // namespace sunder
