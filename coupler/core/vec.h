#pragma once
// Vectors and rotations for all folders. World coordinates, SI, z up.
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace sunder {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;  // Eigen's constructor takes w, x, y, z

/// Twice the area of the triangle (0, a, b), counter-clockwise.
inline double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Rotation by the angle |w| [rad] about w; exact for any angle.
Quat rotation_from_vector(const Vec3& w);

/// Shortest rotation vector of q [rad], with length at most pi. Inverse of rotation_from_vector.
Vec3 rotation_vector(const Quat& q);

}  // namespace sunder
