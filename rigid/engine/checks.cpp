#include "rigid/engine/checks.h"

#include <cmath>

#include "coupler/core/convex_surface.h"

namespace sunder::rigid {
namespace {

constexpr double kUnitTolerance = 1e-6;  // of |q| [-]
/// Share of (diagonal of the bounds)^3 below which a convex part is flat.
constexpr double kFlatShare = 1e-12;  // [-]

bool finite(const BodyMotion& m) {
  return m.position.allFinite() && m.orientation.coeffs().allFinite() && m.velocity.allFinite() &&
         m.angular_momentum.allFinite();
}

void check_shape(const RigidBody& body) {
  if (const auto* sphere = std::get_if<SphereShape>(&body.shape)) {
    if (!(sphere->radius > 0.0) || !std::isfinite(sphere->radius))
      reject_body(body, "shape.radius", fmt::format("is {} m, must be positive and finite", sphere->radius));
  } else if (const auto* box = std::get_if<BoxShape>(&body.shape)) {
    const Vec3& h = box->half_size;
    if (!h.allFinite() || !(h.minCoeff() > 0.0))
      reject_body(body, "shape.half_size",
                  fmt::format("is ({}, {}, {}) m, must be positive and finite", h.x(), h.y(), h.z()));
  } else if (std::holds_alternative<HalfSpaceShape>(body.shape)) {
    if (!body.is_static) reject_body(body, "shape", "is a half space that moves; make it static or use a box");
  } else if (std::get<ConvexShape>(body.shape).parts.empty()) {
    reject_body(body, "shape.parts", "is empty; give at least one convex part");
  }
}

}  // namespace

void reject_body(const RigidBody& body, const std::string& field, const std::string& what) {
  Error error(Exit::kBadInput, "bad_body", fmt::format("body {} '{}': {} {}", body.id, body.name, field, what));
  error.field = field;
  error.body = std::to_string(body.id);
  throw error;
}

void reject_predicted(BodyId id, const std::string& what) {
  Error error(Exit::kBadInput, "bad_predicted_state", fmt::format("predicted state of body {}: {}", id, what));
  error.body = std::to_string(id);
  throw error;
}

double check_corners(const RigidBody& body, const std::vector<Vec3>& part, const std::string& field) {
  if (part.size() < 4)
    reject_body(body, field, fmt::format("has {} corners, needs at least 4; leave the part out", part.size()));
  Vec3 low = part.front(), high = part.front();
  for (const Vec3& p : part) {
    if (!p.allFinite())
      reject_body(body, field, fmt::format("has a corner ({}, {}, {}) that is not finite", p.x(), p.y(), p.z()));
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).norm();
}

void check_not_flat(const RigidBody& body, const Surface& hull, double diagonal, const std::string& field) {
  if (const double volume = enclosed_volume(hull); !(volume > kFlatShare * diagonal * diagonal * diagonal))
    reject_body(body, field, fmt::format("has volume {} m^3, must enclose some; leave flat parts out", volume));
}

void check_body(const RigidBody& body) {
  if (body.id == 0) reject_body(body, "id", "is 0, which is never used; count from 1");
  const BodyMotion& m = body.motion;
  if (!finite(m)) reject_body(body, "motion", "holds a number that is not finite");
  const double length = m.orientation.norm();
  if (std::abs(length - 1.0) > kUnitTolerance)
    reject_body(body, "motion.orientation", fmt::format("has length {}, must be 1; normalize it", length));
  check_shape(body);
  if (body.is_static) return;
  if (!std::isfinite(body.mass) || !(body.mass > 0.0))
    reject_body(body, "mass", fmt::format("is {} kg, must be positive and finite; or make the body static", body.mass));
  const Vec3& inertia = body.principal_inertia;
  if (!inertia.allFinite() || !(inertia.minCoeff() > 0.0))
    reject_body(body, "principal_inertia",
                fmt::format("is ({}, {}, {}) kg m^2, must be positive and finite; or make the body static", inertia.x(),
                            inertia.y(), inertia.z()));
}

void check_predicted(const PredictedState& predicted) {
  if (!finite(predicted.motion)) reject_predicted(predicted.id, "holds a number that is not finite");
  const double length = predicted.motion.orientation.norm();
  if (std::abs(length - 1.0) > kUnitTolerance)
    reject_predicted(predicted.id, fmt::format("orientation has length {}, must be 1", length));
}

void check_window(double window_s) {
  if (!(window_s > 0.0) || !std::isfinite(window_s))
    throw Error(Exit::kBadInput, "bad_predicted_state", fmt::format("window_s is {} s, must be positive", window_s));
}

void check_laws(const std::vector<ContactLaw>& laws) {
  for (const ContactLaw& law : laws)
    if (!(law.friction >= 0.0) || !std::isfinite(law.friction) || !(law.restitution >= 0.0 && law.restitution <= 1.0))
      throw Error(Exit::kBadInput, "bad_contact_law",
                  fmt::format("contact groups {} and {}: friction {} must be at least 0, restitution {} in 0..1",
                              law.first_group, law.second_group, law.friction, law.restitution));
}

void reject_joint(const Joint& joint, const std::string& what) {
  Error error(
      Exit::kBadInput, "bad_joint",
      fmt::format("joint {} '{}' between bodies {} and {}: {}", joint.id, joint.name, joint.first, joint.second, what));
  error.field = "joint";
  throw error;
}

void check_joint(const Joint& joint) {
  if (joint.id == 0) reject_joint(joint, "id is 0; count from 1");
  if (joint.first == 0) reject_joint(joint, "its first end must be a body; only the second may be the world (0)");
  if (joint.first == joint.second) reject_joint(joint, "both ends are one body");
  if (joint.kind < Joint::Kind::kBall || joint.kind > Joint::Kind::kFixed)
    reject_joint(joint, fmt::format("kind {} is none", static_cast<int>(joint.kind)));
  for (const Joint::Frame& frame : {joint.first_frame, joint.second_frame}) {
    if (!frame.position.allFinite() || !frame.orientation.coeffs().allFinite())
      reject_joint(joint, "a frame holds a number that is not finite");
    const double length = frame.orientation.norm();
    if (std::abs(length - 1.0) > kUnitTolerance)
      reject_joint(joint, fmt::format("an orientation has length {}, must be 1; normalize it", length));
  }
}

}  // namespace sunder::rigid
