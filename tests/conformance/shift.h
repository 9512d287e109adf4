#pragma once
// Change of the angular momentum of two colliding bodies in a window, and the part of it that an engine may cause.
#include <map>

#include "tests/conformance/play.h"
#include "tests/conformance/report.h"

namespace sunder::conformance {

/// Change of the angular momentum of two bodies in a window. Observed are the changes against the predicted states: dv
/// of velocity, dL of angular momentum, dx of position. In a window of length H (rigid/README.md) impulses J at its
/// start also move the bodies, impulses K at its end do not, and poses move by s. If J and K each act at one point, the
/// change is the sum of s x (p - K), with p = m v after the window. K is not observed, only s - H K/m = dx - H dv. So
/// the sum of (dx - H dv) x p misses d x K, where d is the motion of the first body relative to the second one in the
/// window. This is normal to d: along d the two sums are equal, whatever impulses the engine applied at either end.
struct Shift {
  Vec3 change = Vec3::Zero();  // of angular momentum [kg m^2/s]
  Vec3 moved = Vec3::Zero();   // part of it due to moved poses
  double apart = 0.0;          // relative motion of the poses [m]
  double rest = 0.0;           // component of change - moved along d
};

using Motions = std::map<BodyId, BodyMotion>;

/// Shift of the window from `before` to the present motions of the play's two bodies; `about`: a fixed point.
Shift shift(const Play& play, const Motions& before, const Vec3& about, double window_s);

/// Sums shifts and judges them.
class ShiftRows {
 public:
  /// Starts from the present motions. `reach_m`: largest distance of a surface point from its body's centre.
  ShiftRows(const Play& play, double window_s, double reach_m);
  /// To be called before and after each window.
  void before(const Play& play);
  void after(const Play& play);
  /// Adds rows `angular` and `angular_rest`, relative to `unit` [kg m^2/s]; `exact`: tolerance of the second one.
  void judge(const Play& play, Report& report, double unit, double exact) const;

 private:
  Vec3 centre_, start_;
  double window_s_, allowed_ = 0.0;
  Motions before_;
  double apart_ = 0.0, rest_ = 0.0;
  Vec3 moved_ = Vec3::Zero();
};

}  // namespace sunder::conformance
