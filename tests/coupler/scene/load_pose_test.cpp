// Poses of scenes: turns by a quaternion, and by axis and angle.
#include <cmath>

#include <gtest/gtest.h>

#include "coupler/scene/load.h"

using namespace sunder;

namespace {

proto::Pose turned(const Vec3& axis, double angle_deg) {
  proto::Pose p;
  auto* r = p.mutable_rotation();
  r->mutable_axis()->set_x(axis.x()), r->mutable_axis()->set_y(axis.y()), r->mutable_axis()->set_z(axis.z());
  r->set_angle_deg(angle_deg);
  return p;
}

}  // namespace

TEST(Pose, ByAxisAndAngleIsThatOfItsQuaternion) {
  proto::Pose by_quaternion;
  by_quaternion.mutable_orientation()->set_w(std::sqrt(0.5)),
      by_quaternion.mutable_orientation()->set_x(std::sqrt(0.5));
  const Quat q = scene::to_quat(by_quaternion), r = scene::to_quat(turned({3.0, 0.0, 0.0}, 90.0));
  EXPECT_LT((q.coeffs() - r.coeffs()).norm(), 1e-15);
  EXPECT_LT((r * Vec3(0, 1, 0) - Vec3(0, 0, 1)).norm(), 1e-15);  // counter-clockwise
  const Vec3 diagonal = scene::to_quat(turned({1.0, 1.0, 1.0}, -120.0)) * Vec3(1, 0, 0);
  EXPECT_LT((diagonal - Vec3(0, 0, 1)).norm(), 1e-15);
}

TEST(Pose, TurnsAboutZUnlessItSaysAnotherAxisAndNotAtAllWithoutATurn) {
  proto::Pose p;
  EXPECT_EQ(scene::to_quat(p).coeffs(), Quat::Identity().coeffs());
  p.mutable_rotation()->set_angle_deg(450.0);  // one turn and a quarter
  EXPECT_LT((scene::to_quat(p) * Vec3(1, 0, 0) - Vec3(0, 1, 0)).norm(), 1e-15);
  EXPECT_EQ(scene::to_quat(turned({0, 0, 2}, 0.0)).coeffs(), Quat::Identity().coeffs());
}
