#pragma once
// A rigid body as both processes know it: description once, motion every window.
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
struct HalfSpaceShape {};  // everything below the body's xy plane
/// Triangles that enclose a solid, in body coordinates [m].
struct Surface {
  std::vector<Vec3> corners;
  std::vector<std::array<int, 3>> triangles;  // counter-clockwise seen from outside
};
/// Convex parts, each by its corners in body coordinates [m]; together they are the body.
struct ConvexShape {
  std::vector<std::vector<Vec3>> parts;
  std::shared_ptr<const Surface> surface = nullptr;  // of a solid that need not be convex; engines do without
};
using Shape = std::variant<SphereShape, BoxShape, HalfSpaceShape, ConvexShape>;

/// Where a body is and how it moves.
struct BodyMotion {
  Vec3 position = Vec3::Zero();          // of the centre of mass [m]
  Quat orientation = Quat::Identity();   // body axes (principal) to world
  Vec3 velocity = Vec3::Zero();          // [m/s]
  Vec3 angular_momentum = Vec3::Zero();  // about the centre of mass [kg m^2/s]
};

struct RigidBody {
  BodyId id = 0;
  std::string name;
  bool is_static = false;
  double mass = 0.0;                      // [kg]; 0 where static
  Vec3 principal_inertia = Vec3::Zero();  // [kg m^2], about the body axes
  BodyMotion motion;
  Shape shape = SphereShape{0.0};
  std::uint32_t contact_group = 0;  // indexes the table of contact coefficients

  Vec3 angular_velocity() const;  // [rad/s], world
  Vec3 apply_inverse_inertia(const Vec3& world) const;
  Vec3 apply_inertia(const Vec3& world) const;
  double kinetic_energy() const;  // [J]
  /// Moves freely for h seconds: position by velocity, orientation by the midpoint rule with the
  /// angular momentum held (second order, exact for a sphere).
  void drift(double h);
};

/// Coefficients between bodies of two contact groups (order does not matter).
struct ContactLaw {
  std::uint32_t first_group = 0, second_group = 0;
  double friction = 0.5;
  double restitution = 0.0;
};

/// What holds two bodies together, or one to the world. A frame is in body coordinates (of the world where `second` is
/// 0); the axis of a hinge or slider is its z axis. Where the joint is not strained both frames coincide.
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
