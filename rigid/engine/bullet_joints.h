#pragma once
// All joints of a world. Private to the adapter; units are Bullet's (bullet_shapes.h). Bullet's iterations include the
// rows of joints, so that contacts and joints act on one another. In a chain of rods they converge too slowly, so the
// remaining error of all joints is solved here directly.
#include <Eigen/SparseCholesky>

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "rigid/engine/bullet_joint.h"

namespace sunder::rigid {

/// The joints of a world, with a sparse direct solver for all that act in a window.
class BulletJoints {
 public:
  using Impulses = std::map<std::uint32_t, std::array<JointImpulse, 2>>;

  void add(std::uint32_t id, std::unique_ptr<BulletJoint> joint) { joints_[id] = std::move(joint); }
  bool has(std::uint32_t id) const { return joints_.count(id) > 0; }
  const std::map<std::uint32_t, std::unique_ptr<BulletJoint>>& all() const { return joints_; }
  /// Moves all joints out; none is left.
  std::map<std::uint32_t, std::unique_ptr<BulletJoint>> take_out();
  /// Stored impulses of all joints.
  Impulses impulses() const;

  /// Stops a joint for good. It stays in the world, so that its bodies still do not collide.
  void release(std::uint32_t id) { released_.insert(id); }
  /// Selects the joints that act in this window: not released, and without a body of `solved`. False where there is
  /// none.
  bool choose(const std::set<BodyId>& solved);
  bool any() const { return !acting_.empty(); }
  bool hold(BodyId id) const { return held_.count(id) > 0; }

  /// Prepares a solve at the present poses. Its target is the window's end (kSolve), or velocities without strain
  /// (kRelax).
  void begin(BulletJoint::Stage stage, double window_s);
  /// Applies the stored impulses to the bodies.
  void push();
  /// Stores what Bullet's solve has applied since push().
  void take_in(double window_s);
  /// Solves all joints at once for their targets. Returns the largest change of a velocity [m/s or rad/s].
  double correct();
  /// Corrects targets by the poses at which bodies would end now. Returns the largest remaining error [m/s or rad/s].
  double mend(double window_s, const std::function<btTransform(BodyId)>& end_of);

 private:
  void factorize();

  std::map<std::uint32_t, std::unique_ptr<BulletJoint>> joints_;
  std::vector<BulletJoint*> acting_;
  std::set<BodyId> held_;             // bodies of acting joints
  std::set<std::uint32_t> released_;  // joints
  BulletJoint::Stage stage_ = BulletJoint::kSolve;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors_;  // of J M^-1 J^T
  std::vector<int> first_rows_;                                 // of each acting joint; the last entry: all rows
};

}  // namespace sunder::rigid
