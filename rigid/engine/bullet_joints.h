#pragma once
// All joints of a world together. Private to the adapter; units are Bullet's (bullet_shapes.h).
// Bullet's iterations see the joints' rows, so that contacts and joints act on one another; but in a chain of rods they
// converge far too slowly, so what they leave is solved here directly.
#include <Eigen/SparseCholesky>

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "rigid/engine/bullet_joint.h"

namespace sunder::rigid {

class BulletJoints {
 public:
  using Impulses = std::map<std::uint32_t, std::array<JointImpulse, 2>>;

  void add(std::uint32_t id, std::unique_ptr<BulletJoint> joint) { joints_[id] = std::move(joint); }
  bool has(std::uint32_t id) const { return joints_.count(id) > 0; }
  const std::map<std::uint32_t, std::unique_ptr<BulletJoint>>& all() const { return joints_; }
  std::map<std::uint32_t, std::unique_ptr<BulletJoint>> take_out();
  Impulses impulses() const;

  /// It stays, so that its bodies still go through one another, and acts no longer.
  void release(std::uint32_t id) { released_.insert(id); }
  /// Those that have let go or hold a body of `solved` are left out of the window. False where none is left.
  bool choose(const std::set<BodyId>& solved);
  bool any() const { return !acting_.empty(); }
  bool hold(BodyId id) const { return held_.count(id) > 0; }

  /// For a solve at the present poses; aims at the window's end, or at velocities that strain nothing.
  void begin(BulletJoint::Stage stage, double window_s);
  /// Gives the bodies the impulses that are known so far.
  void push();
  /// Takes in what Bullet's solve did, which came after push().
  void take_in(double window_s);
  /// Solves for the aim, all joints at once. Returns the largest change of a velocity [m/s or rad/s].
  double correct();
  /// Mends aims by the poses at which bodies would end now; returns how fast they miss them [m/s or rad/s].
  double mend(double window_s, const std::function<btTransform(BodyId)>& end_of);

 private:
  void factorize();

  std::map<std::uint32_t, std::unique_ptr<BulletJoint>> joints_;
  std::vector<BulletJoint*> acting_;
  std::set<BodyId> held_;             // by those
  std::set<std::uint32_t> released_;  // for good
  BulletJoint::Stage stage_ = BulletJoint::kSolve;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors_;  // of J M^-1 J^T
  std::vector<int> first_rows_;                                 // of each acting joint, and the number of all
};

}  // namespace sunder::rigid
