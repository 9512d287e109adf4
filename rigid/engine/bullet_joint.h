#pragma once
// A joint as rows of Bullet's solver. Private to the adapter. Lengths and masses are Bullet's (bullet_shapes.h).
//
// The scheme is that of RATTLE: the first solve of a window aims at poses that satisfy the joint at the window's end
// (its rows are those of the start), the second takes out the velocities that would strain it there. So the energy of
// a pendulum oscillates and does not drift; Bullet's own joints, which push with velocities against a strain that is
// already there, feed it. Both bodies are pushed at one point, with one impulse: momentum and angular momentum are kept
// to round-off.
#include <btBulletDynamicsCommon.h>

#include <array>
#include <cstdint>
#include <vector>

#include "coupler/core/body.h"

namespace sunder::rigid {

/// One for each row. Not a vector in the room: that of the last window would do work where the joint has turned since.
using JointImpulse = std::array<double, 6>;  // [g cm/s or g cm^2/s]

class BulletJoint final : public btTypedConstraint {
 public:
  enum Stage { kSolve, kRelax };
  /// The bodies outlive the joint.
  BulletJoint(const Joint& joint, btRigidBody& first, btRigidBody& second);

  struct Row {
    btVector3 linear{0, 0, 0};  // of the second body; the first has its negative
    btVector3 first_angular{0, 0, 0}, second_angular{0, 0, 0};
  };
  /// At the poses of the last find_rows().
  const std::vector<Row>& rows() const { return rows_; }
  void find_rows();

  /// Of the next solve: the velocities that lead to an unstrained joint at the end of the window, to first order. A
  /// strain that is there already is taken back in shares, and slowly: nothing that is in the way is struck.
  void aim(double window_s);
  /// Of the next solve: velocities that do not strain the joint.
  void aim_still() { aim_.fill(0.0); }
  /// Mends the aim by what comes of the present velocities: poses at the end of the window. Returns how far off they
  /// are per second [m/s or rad/s, the largest].
  double mend(const btTransform& first_end, const btTransform& second_end, double window_s);
  /// What a row still needs to reach its aim.
  double missing(int row) const { return aim_[row] - rate(row); }

  /// Gives both bodies the impulse that the stage ended with last.
  void push(Stage stage) { hand_out(impulses_[stage].data()); }
  /// Adds what Bullet's solve has given them since.
  void take_in(Stage stage, double window_s);
  /// Gives them an impulse for each row. Returns the largest change of a velocity [m/s or rad/s].
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
  double rate(int row) const;  // at which the present velocities strain the joint
  Strain strain(const btTransform& first, const btTransform& second) const;

  Joint::Kind kind_;
  btTransform first_frame_, second_frame_;
  Strain aim_{};     // change of the strain per second
  Strain wanted_{};  // strain at the window's end
  std::array<JointImpulse, 2> impulses_{};
  btVector3 first_arm_{0, 0, 0}, second_arm_{0, 0, 0};  // to the point where both are pushed, of find_rows()
  std::vector<Row> rows_;
  btJointFeedback feedback_;
};

}  // namespace sunder::rigid
