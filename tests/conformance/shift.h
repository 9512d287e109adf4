#pragma once
// Angular momentum of two bodies that meet: what a window did to it, and what of that an engine may do.
#include <map>

#include "tests/conformance/play.h"
#include "tests/conformance/report.h"

namespace sunder::conformance {

/// What a window did to the angular momentum of two bodies, from what can be seen: changes dv of velocity, dL of spin
/// and dx of position against the handbacks. A window (rigid/README.md) has impulses J at the start, which also move
/// the bodies, and K at its end, which do not, and moves poses by s. With J and K at one point each the change is the
/// sum of s x (p - K), p = m v after the window. Only s - H K/m = dx - H dv is seen, not K, so the sum of (dx - H dv) x
/// p leaves out d x K, d being the way of the first body past the second one in the window. That is at right angles to
/// d: along d the two sums are equal, whatever the engine did at which end of the window.
struct Shift {
  Vec3 change = Vec3::Zero();  // of angular momentum
  Vec3 moved = Vec3::Zero();   // the part that moved poses explain
  double apart = 0.0;          // how far poses were moved against one another [m]
  double rest = 0.0;           // of change - moved, along d
};

using Motions = std::map<BodyId, BodyMotion>;

/// Of the window from `before` to where the two bodies of the play are now; `about` a fixed point.
Shift shift(const Play& play, const Motions& before, const Vec3& about, double window_s);

/// Adds up shifts, and judges them.
class ShiftRows {
 public:
  /// From the bodies as they are. `reach_m`: of their surfaces from their centres.
  ShiftRows(const Play& play, double window_s, double reach_m);
  /// Before and after a window.
  void before(const Play& play);
  void after(const Play& play);
  /// Rows `angular` and `angular_rest`, in shares of `unit` [kg m^2/s]; `exact`: tolerance of the latter.
  void judge(const Play& play, Report& report, double unit, double exact) const;

 private:
  Vec3 centre_, start_;
  double window_s_, allowed_ = 0.0;
  Motions before_;
  double apart_ = 0.0, rest_ = 0.0;
  Vec3 moved_ = Vec3::Zero();
};

}  // namespace sunder::conformance
