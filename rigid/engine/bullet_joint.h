#pragma once
// A joint as rows of Bullet's solver. Private to the adapter. Lengths and masses are Bullet's (bullet_shapes.h).
//
// The scheme is RATTLE. The first solve of a window finds poses that satisfy the joint at the window's end, with the
// joint's rows at the start. The second solve removes velocities that would strain the joint there. So the energy of a
// pendulum oscillates and does not drift. Bullet's own joints turn an existing strain into velocity, which adds energy.
// One impulse acts on both bodies at one point: momentum and angular momentum are kept to round-off.
#include <btBulletDynamicsCommon.h>

#include <array>
#include <cstdint>
#include <vector>

#include "coupler/core/body.h"

namespace sunder::rigid {

/// Impulse of each row. Stored by row and not as a world vector: the old vector would do work once the joint has
/// turned.
using JointImpulse = std::array<double, 6>;  // [g cm/s or g cm^2/s]

/// A ball joint, hinge, slider or fixed joint with its rows in Bullet's solver.
class BulletJoint final : public btTypedConstraint {
 public:
  enum Stage { kSolve, kRelax };
  /// The bodies outlive the joint.
  BulletJoint(const Joint& joint, btRigidBody& first, btRigidBody& second);

  struct Row {
    btVector3 linear{0, 0, 0};  // direction on the second body; the first body has its negative
    btVector3 first_angular{0, 0, 0}, second_angular{0, 0, 0};
  };
  /// Rows at the poses of the last find_rows().
  const std::vector<Row>& rows() const { return rows_; }
  /// Sets the rows at the present poses.
  void find_rows();

  /// Sets the target of the next solve: velocities that leave the joint without strain at the end of the window, to
  /// first order. An existing strain is reduced by a share per window, at a limited speed, so that bodies in the way
  /// are not struck.
  void aim(double window_s);
  /// Sets the target of the next solve to velocities that do not change the strain.
  void aim_still() { aim_.fill(0.0); }
  /// Corrects the target by the poses to which the present velocities lead at the end of the window. Returns the
  /// largest remaining error of strain per second [m/s or rad/s].
  double mend(const btTransform& first_end, const btTransform& second_end, double window_s);
  /// Rate of strain that a row still needs to reach its target [cm/s or rad/s].
  double missing(int row) const { return aim_[row] - rate(row); }

  /// Gives both bodies the impulse with which this stage ended last.
  void push(Stage stage) { hand_out(impulses_[stage].data()); }
  /// Adds to the stored impulse what Bullet's solve has applied since push().
  void take_in(Stage stage, double window_s);
  /// Applies and stores an impulse for each row. Returns the largest change of a velocity [m/s or rad/s].
  double give(Stage stage, const double* impulses);

  const std::array<JointImpulse, 2>& impulses() const { return impulses_; }
  void set_impulses(const std::array<JointImpulse, 2>& impulses) { impulses_ = impulses; }

  void getInfo1(btConstraintInfo1* info) override;
  void getInfo2(btConstraintInfo2* info) override;
  void setParam(int, btScalar, int) override {}
  btScalar getParam(int, int) const override { return 0.0; }

 private:
  static constexpr int kMostRows = 6;
  using Strain = std::array<double, kMostRows>;

  int linear_rows() const { return kind_ == Joint::Kind::kSlider ? 2 : 3; }
  int row_count() const;
  const btVector3& along(int row) const { return row < linear_rows() ? rows_[row].linear : rows_[row].second_angular; }
  void hand_out(const double* impulses);
  double rate(int row) const;  // rate of strain at the present velocities
  Strain strain(const btTransform& first, const btTransform& second) const;

  Joint::Kind kind_;
  btTransform first_frame_, second_frame_;
  Strain aim_{};     // target rate of strain [cm/s or rad/s]
  Strain wanted_{};  // target strain at the window's end [cm or rad]
  std::array<JointImpulse, 2> impulses_{};
  btVector3 first_arm_{0, 0, 0}, second_arm_{0, 0, 0};  // from centres to the point of the impulse, at find_rows()
  std::vector<Row> rows_;
  btJointFeedback feedback_;
};

}  // namespace sunder::rigid
