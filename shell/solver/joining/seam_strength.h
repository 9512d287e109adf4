#pragma once
// Seams that hold up to a force for each length, and then open.
#include <vector>

#include "shell/solver/joining/stitching.h"

namespace sunder::shell {

/// Measures the force that seams transmit, and opens them where it is too large. A dependent control point of mass m
/// with the force f of its own shell accelerates with its seam by a: the seam gives it the force m a - f. Over the
/// length of the seam that the function of the control point stands for, the integral of its values, this is the force
/// per length; it is exact where stress is uniform.
class SeamStrength {
 public:
  SeamStrength() = default;
  /// Seams without a strength are left alone. `seams` and `shells` are those of the stitching.
  SeamStrength(const std::vector<Seam>& seams, const std::vector<const ShellModel*>& shells,
               const Stitching& stitching);

  bool empty() const { return points_.empty(); }
  /// Stores the forces of shells. Call it before Stitching::move_forces.
  void store_forces(const std::vector<ShellRef>& shells);
  /// Takes the forces that seams transmit into the running mean, for a substep of `dt` [s]. Call it after move_forces.
  void measure(const std::vector<ShellRef>& shells, double dt);
  /// Opens seams where the mean force is beyond their strength. Returns whether any has opened.
  bool open(const std::vector<ShellRef>& shells, const std::vector<Seam>& seams, Stitching& stitching);

  template <class A>
  friend void archive(A& a, SeamStrength& s) {
    for (Point& p : s.points_) archive_all(a, p.mean, p.holds);
  }

 private:
  // A dependent control point on the edge of its shell at a seam.
  struct Point {
    int seam, shell, slot;
    double mass;                // of the control point without its seam [kg]
    double most;                // force that it bears [N]
    double share;               // its place, as a share of the seam's first edge
    double response;            // time over which the force is averaged [s]
    Vec3 force = Vec3::Zero();  // of its shell [N]
    Vec3 mean = Vec3::Zero();   // force that the seam gives it [N]
    bool holds = true;
  };
  std::vector<Point> points_;
};

}  // namespace sunder::shell
