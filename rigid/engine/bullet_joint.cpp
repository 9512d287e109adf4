#include "rigid/engine/bullet_joint.h"

#include <algorithm>
#include <cmath>

#include "rigid/engine/bullet_shapes.h"

namespace sunder::rigid {
namespace {

/// Share of a strain at the start of a window that the window removes, and the largest speed of it.
constexpr double kStrainShare = 0.2;                              // [-]
constexpr double kCorrectionSpeed = 0.05, kCorrectionSpin = 1.0;  // [m/s], [rad/s]

btTransform frame(const Joint::Frame& f) {
  const Quat& q = f.orientation;
  return btTransform(btQuaternion(q.x(), q.y(), q.z(), q.w()),
                     kLengthScale * btVector3(f.position.x(), f.position.y(), f.position.z()));
}

/// Pairs of axes, one of each body's frame, that a joint keeps at right angles (columns of the frames).
struct AxisPair {
  int first, second;
};
constexpr AxisPair kHingePairs[] = {{0, 2}, {1, 2}}, kAllPairs[] = {{1, 2}, {2, 0}, {0, 1}};

}  // namespace

BulletJoint::BulletJoint(const Joint& joint, btRigidBody& first, btRigidBody& second)
    : btTypedConstraint(D6_CONSTRAINT_TYPE, first, second),
      kind_(joint.kind),
      first_frame_(frame(joint.first_frame)),
      second_frame_(frame(joint.second_frame)) {
  setJointFeedback(&feedback_);
}

int BulletJoint::row_count() const {
  switch (kind_) {
    case Joint::Kind::kBall:
      return 3;
    case Joint::Kind::kHinge:
    case Joint::Kind::kSlider:
      return 5;
    default:
      return 6;
  }
}

BulletJoint::Strain BulletJoint::strain(const btTransform& first, const btTransform& second) const {
  const btTransform a = first * first_frame_, b = second * second_frame_;
  const btVector3 apart = b.getOrigin() - a.getOrigin();
  Strain strain{};
  const int linear = linear_rows();
  for (int k = 0; k < linear; ++k)
    strain[k] = kind_ == Joint::Kind::kSlider ? a.getBasis().getColumn(k).dot(apart) : apart[k];
  const AxisPair* pairs = kind_ == Joint::Kind::kHinge ? kHingePairs : kAllPairs;
  for (int k = linear; k < row_count(); ++k) {
    const AxisPair& pair = pairs[k - linear];
    strain[k] = a.getBasis().getColumn(pair.first).dot(b.getBasis().getColumn(pair.second));
  }
  return strain;
}

void BulletJoint::find_rows() {
  const btTransform a = m_rbA.getWorldTransform() * first_frame_, b = m_rbB.getWorldTransform() * second_frame_;
  // The axis of a slider is fixed to the first body, the point on it to the second.
  const bool slides = kind_ == Joint::Kind::kSlider;
  const btVector3 at = slides ? b.getOrigin() : 0.5 * (a.getOrigin() + b.getOrigin());
  first_arm_ = at - m_rbA.getCenterOfMassPosition();
  second_arm_ = at - m_rbB.getCenterOfMassPosition();
  rows_.resize(row_count());
  const int linear = linear_rows();
  for (int k = 0; k < linear; ++k) {
    const btVector3 direction = slides ? a.getBasis().getColumn(k) : btVector3(k == 0, k == 1, k == 2);
    rows_[k] = {direction, -first_arm_.cross(direction), second_arm_.cross(direction)};
  }
  const AxisPair* pairs = kind_ == Joint::Kind::kHinge ? kHingePairs : kAllPairs;
  for (int k = linear; k < row_count(); ++k) {
    // d(u.w)/dt = (w x u).(w_second - w_first)
    const AxisPair& pair = pairs[k - linear];
    const btVector3 turn = b.getBasis().getColumn(pair.second).cross(a.getBasis().getColumn(pair.first));
    rows_[k] = {btVector3(0, 0, 0), -turn, turn};
  }
}

double BulletJoint::rate(int k) const {
  const Row& row = rows_[k];
  return row.linear.dot(m_rbB.getLinearVelocity() - m_rbA.getLinearVelocity()) +
         row.first_angular.dot(m_rbA.getAngularVelocity()) + row.second_angular.dot(m_rbB.getAngularVelocity());
}

void BulletJoint::aim(double window_s) {
  const Strain now = strain(m_rbA.getWorldTransform(), m_rbB.getWorldTransform());
  for (int k = 0; k < row_count(); ++k) {
    const double most = window_s * (k < linear_rows() ? kLengthScale * kCorrectionSpeed : kCorrectionSpin);
    const double back = std::clamp(kStrainShare * now[k], -most, most);
    wanted_[k] = now[k] - back;
    aim_[k] = -back / window_s;
  }
}

double BulletJoint::mend(const btTransform& first_end, const btTransform& second_end, double window_s) {
  const Strain end = strain(first_end, second_end);
  double worst = 0.0;
  for (int k = 0; k < row_count(); ++k) {
    const double off = (end[k] - wanted_[k]) / window_s;
    aim_[k] = rate(k) - off;
    worst = std::max(worst, std::abs(off) / (k < linear_rows() ? kLengthScale : 1.0));
  }
  return worst;
}

void BulletJoint::hand_out(const double* impulses) {
  btVector3 push(0, 0, 0), turn(0, 0, 0);  // on the second body
  for (int k = 0; k < row_count(); ++k) (k < linear_rows() ? push : turn) += impulses[k] * along(k);
  m_rbA.applyImpulse(-push, first_arm_);
  m_rbA.applyTorqueImpulse(-turn);
  m_rbB.applyImpulse(push, second_arm_);
  m_rbB.applyTorqueImpulse(turn);
}

void BulletJoint::take_in(Stage stage, double window_s) {
  const btVector3 push = -window_s * feedback_.m_appliedForceBodyA;
  const btVector3 turn = -window_s * feedback_.m_appliedTorqueBodyA - first_arm_.cross(push);
  for (int k = 0; k < linear_rows(); ++k) impulses_[stage][k] += push.dot(along(k));
  const int angular = row_count() - linear_rows();
  Mat3 axes = Mat3::Identity();
  for (int k = 0; k < angular; ++k) {
    const btVector3& axis = along(linear_rows() + k);
    axes.col(k) = Vec3(axis.x(), axis.y(), axis.z());
  }
  if (angular == 2) axes.col(2) = axes.col(0).cross(axes.col(1));  // the free axis of a hinge
  const Vec3 parts = axes.inverse() * Vec3(turn.x(), turn.y(), turn.z());
  for (int k = 0; k < angular; ++k) impulses_[stage][linear_rows() + k] += parts[k];
}

double BulletJoint::give(Stage stage, const double* impulses) {
  const btVector3 linear[] = {m_rbA.getLinearVelocity(), m_rbB.getLinearVelocity()};
  const btVector3 angular[] = {m_rbA.getAngularVelocity(), m_rbB.getAngularVelocity()};
  hand_out(impulses);
  for (int k = 0; k < row_count(); ++k) impulses_[stage][k] += impulses[k];
  return std::max({(m_rbA.getLinearVelocity() - linear[0]).length() / kLengthScale,
                   (m_rbB.getLinearVelocity() - linear[1]).length() / kLengthScale,
                   (m_rbA.getAngularVelocity() - angular[0]).length(),
                   (m_rbB.getAngularVelocity() - angular[1]).length()});
}

void BulletJoint::getInfo1(btConstraintInfo1* info) {
  info->m_numConstraintRows = row_count();
  info->nub = 0;
}

void BulletJoint::getInfo2(btConstraintInfo2* info) {
  for (int k = 0; k < row_count(); ++k) {
    const Row& row = rows_[k];
    const int at = k * info->rowskip;
    for (int i = 0; i < 3; ++i) {
      info->m_J1linearAxis[at + i] = -row.linear[i];
      info->m_J2linearAxis[at + i] = row.linear[i];
      info->m_J1angularAxis[at + i] = row.first_angular[i];
      info->m_J2angularAxis[at + i] = row.second_angular[i];
    }
    info->m_constraintError[at] = aim_[k];
  }
}

}  // namespace sunder::rigid
