#include "coupler/link/messages.h"

#include <cmath>

#include "coupler/core/error.h"

namespace sunder::link {
namespace {

template <class... Args>
void check(bool good, fmt::format_string<Args...> format, Args&&... args) {
  if (!good) throw Error(Exit::kPeerLost, "bad_message", fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace

proto::Vec3 encode(const Vec3& v) {
  proto::Vec3 m;
  m.set_x(v.x()), m.set_y(v.y()), m.set_z(v.z());
  return m;
}

proto::Quaternion encode(const Quat& q) {
  proto::Quaternion m;
  m.set_w(q.w()), m.set_x(q.x()), m.set_y(q.y()), m.set_z(q.z());
  return m;
}

proto::RigidBody encode(const RigidBody& b) {
  proto::RigidBody m;
  m.set_id(b.id), m.set_name(b.name), m.set_is_static(b.is_static), m.set_mass(b.mass);
  *m.mutable_principal_inertia() = encode(b.principal_inertia);
  *m.mutable_position() = encode(b.motion.position);
  *m.mutable_orientation() = encode(b.motion.orientation);
  *m.mutable_velocity() = encode(b.motion.velocity);
  *m.mutable_angular_momentum() = encode(b.motion.angular_momentum);
  m.set_contact_group(b.contact_group);
  if (const auto* s = std::get_if<SphereShape>(&b.shape)) m.set_sphere_radius_m(s->radius);
  if (const auto* s = std::get_if<BoxShape>(&b.shape)) *m.mutable_box_half_size_m() = encode(s->half_size);
  if (std::holds_alternative<HalfSpaceShape>(b.shape)) m.set_half_space(true);
  if (const auto* s = std::get_if<ConvexShape>(&b.shape))
    for (const auto& part : s->parts) {
      auto* p = m.mutable_convex()->add_parts();
      for (const Vec3& c : part)
        for (int d = 0; d < 3; ++d) p->add_corners(c[d]);
    }
  return m;
}

Vec3 decode(const proto::Vec3& v, const std::string& field) {
  const Vec3 r(v.x(), v.y(), v.z());
  check(r.allFinite(), "{} is ({}, {}, {}): not finite", field, v.x(), v.y(), v.z());
  return r;
}

Quat decode(const proto::Quaternion& q, const std::string& field) {
  const Quat r(q.w(), q.x(), q.y(), q.z());
  check(r.coeffs().allFinite() && std::abs(r.norm() - 1.0) < kQuaternionTolerance,
        "{} is ({}, {}, {}, {}): not of unit length", field, q.w(), q.x(), q.y(), q.z());
  return r;
}

RigidBody decode(const proto::RigidBody& m, const std::string& field) {
  RigidBody b;
  b.id = m.id(), b.name = m.name(), b.is_static = m.is_static(), b.mass = m.mass();
  check(b.id != 0, "{}.id is 0; ids start at 1", field);
  check(b.name.size() < 256, "{}.name has {} bytes; 255 at most", field, b.name.size());
  b.principal_inertia = decode(m.principal_inertia(), field + ".principal_inertia");
  if (!b.is_static)
    check(std::isfinite(b.mass) && b.mass > 0.0 && b.principal_inertia.minCoeff() > 0.0,
          "{}: mass {} and inertia must be positive", field, b.mass);
  b.motion.position = decode(m.position(), field + ".position");
  b.motion.orientation = decode(m.orientation(), field + ".orientation");
  b.motion.velocity = decode(m.velocity(), field + ".velocity");
  b.motion.angular_momentum = decode(m.angular_momentum(), field + ".angular_momentum");
  b.contact_group = m.contact_group();
  switch (m.shape_case()) {
    case proto::RigidBody::kSphereRadiusM:
      check(std::isfinite(m.sphere_radius_m()) && m.sphere_radius_m() > 0.0, "{}.sphere_radius_m is {}", field,
            m.sphere_radius_m());
      b.shape = SphereShape{m.sphere_radius_m()};
      break;
    case proto::RigidBody::kBoxHalfSizeM: {
      const Vec3 half = decode(m.box_half_size_m(), field + ".box_half_size_m");
      check(half.minCoeff() > 0.0, "{}.box_half_size_m must be positive", field);
      b.shape = BoxShape{half};
      break;
    }
    case proto::RigidBody::kHalfSpace:
      b.shape = HalfSpaceShape{};
      break;
    case proto::RigidBody::kConvex: {
      ConvexShape shape;
      check(m.convex().parts_size() >= 1 && m.convex().parts_size() <= kMaxParts, "{}.convex has {} parts", field,
            m.convex().parts_size());
      for (const auto& part : m.convex().parts()) {
        check(part.corners_size() % 3 == 0 && part.corners_size() >= 12 && part.corners_size() <= 3 * kMaxCorners,
              "{}.convex: {} coordinates in a part", field, part.corners_size());
        auto& corners = shape.parts.emplace_back();
        for (int i = 0; i < part.corners_size(); i += 3) {
          corners.emplace_back(part.corners(i), part.corners(i + 1), part.corners(i + 2));
          check(corners.back().allFinite(), "{}.convex: a corner is not finite", field);
        }
      }
      b.shape = std::move(shape);
      break;
    }
    default:
      check(false, "{} has no shape", field);
  }
  return b;
}

std::vector<ContactLaw> decode_contacts(const proto::Load& load) {
  std::vector<ContactLaw> laws;
  for (const auto& c : load.contacts()) {
    check(std::isfinite(c.friction()) && c.friction() >= 0.0, "contacts.friction is {}", c.friction());
    check(c.restitution() >= 0.0 && c.restitution() <= 1.0, "contacts.restitution is {}", c.restitution());
    laws.push_back({c.first_group(), c.second_group(), c.friction(), c.restitution()});
  }
  return laws;
}

}  // namespace sunder::link
