#pragma once
// A rigid body as both processes know it. Its description is sent once, its motion in every window.
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "coupler/core/vec.h"

namespace sunder {

using BodyId = std::uint32_t;  // an identity for the whole run; 0 is never used

struct SphereShape {
  double radius;  // [m]
};
struct BoxShape {
  Vec3 half_size;  // [m]
};
struct HalfSpaceShape {};  // all points below the body's xy plane
/// Triangles that enclose a solid, in body coordinates [m].
struct Surface {
  std::vector<Vec3> corners;
  std::vector<std::array<int, 3>> triangles;  // counter-clockwise seen from outside
};
/// A body made of convex parts, each given by its corners in body coordinates [m].
struct ConvexShape {
  std::vector<std::vector<Vec3>> parts;
  std::shared_ptr<const Surface> surface = nullptr;  // of a solid that may be concave; engines do not need it
};
using Shape = std::variant<SphereShape, BoxShape, HalfSpaceShape, ConvexShape>;

/// Pose and velocities of a body, in world axes.
struct BodyMotion {
  Vec3 position = Vec3::Zero();          // of the centre of mass [m]
  Quat orientation = Quat::Identity();   // body axes (principal) to world
  Vec3 velocity = Vec3::Zero();          // [m/s]
  Vec3 angular_momentum = Vec3::Zero();  // about the centre of mass [kg m^2/s]
};

/// Description and motion of a rigid body. Its origin is the centre of mass, its axes are the principal ones.
struct RigidBody {
  BodyId id = 0;
  std::string name;
  bool is_static = false;
  double mass = 0.0;                      // [kg]; 0 where static
  Vec3 principal_inertia = Vec3::Zero();  // [kg m^2], about the body axes
  BodyMotion motion;
  Shape shape = SphereShape{0.0};
  std::uint32_t contact_group = 0;  // selects the contact law of a pair of bodies

  /// Angular velocity in world axes [rad/s], I^-1 L; zero for a static body.
  Vec3 angular_velocity() const;
  /// I^-1 times a vector in world axes, I being the inertia in world axes. Not for static bodies.
  Vec3 apply_inverse_inertia(const Vec3& world) const;
  /// I times a vector in world axes.
  Vec3 apply_inertia(const Vec3& world) const;
  /// Translation and rotation [J]; zero for a static body.
  double kinetic_energy() const;
  /// Free flight for h seconds. The position follows the velocity, and the orientation free_rotation(). The angular
  /// momentum stays.
  void drift(double h);
};

/// Friction and restitution [-] between bodies of two contact groups, in either order.
struct ContactLaw {
  std::uint32_t first_group = 0, second_group = 0;
  double friction = 0.5;
  double restitution = 0.0;
};

/// A joint between two bodies, or between a body and the world. Frames are in body coordinates; the second one is in
/// world coordinates where `second` is 0. The z axis of a frame is the axis of a hinge or slider. In a joint without
/// strain both frames coincide.
struct Joint {
  enum class Kind { kBall, kHinge, kSlider, kFixed };
  struct Frame {
    Vec3 position = Vec3::Zero();  // [m]
    Quat orientation = Quat::Identity();
  };
  std::uint32_t id = 0;  // counted from 1
  std::string name;
  Kind kind = Kind::kBall;
  BodyId first = 0, second = 0;  // second 0: the world
  Frame first_frame, second_frame;
};

}  // namespace sunder
