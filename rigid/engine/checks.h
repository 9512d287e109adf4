#pragma once
// Checks and rules that all engines share. For adapters.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "rigid/engine/engine.h"

namespace sunder::rigid {

/// Turn per window above which an engine does not use the average angular velocity, because its logarithm is ambiguous
/// from pi on. The solver then gets the predicted angular velocity.
constexpr double kFastTurn = 0.7;  // [rad]

/// Two ids or contact groups, the lower one first.
inline std::pair<std::uint32_t, std::uint32_t> ordered(std::uint32_t a, std::uint32_t b) {
  return {std::min(a, b), std::max(a, b)};
}

/// Throws Error (bad_body) with id, name and field of the body. `what`: value and remedy.
[[noreturn]] void reject_body(const RigidBody& body, const std::string& field, const std::string& what);
/// Checks that a convex part has four corners at least and that all are finite. Returns the diagonal of its bounds [m].
/// Throws Error (bad_body).
double check_corners(const RigidBody& body, const std::vector<Vec3>& part, const std::string& field);
/// Checks that the hull of a part, of this diagonal [m], encloses a volume. Throws Error (bad_body).
void check_not_flat(const RigidBody& body, const Surface& hull, double diagonal, const std::string& field);
/// Throws Error (bad_predicted_state) for the predicted state of a body.
[[noreturn]] void reject_predicted(BodyId id, const std::string& what);
/// Checks id, motion, sizes of the shape, mass and inertia. Corners of convex parts are checked elsewhere. Throws Error
/// (bad_body) with id, name, value and remedy.
void check_body(const RigidBody& body);
/// Checks that a predicted state is finite and its quaternion has length 1. Throws Error (bad_predicted_state).
void check_predicted(const PredictedState& predicted);
/// Calls take(entry, motion) for each entry of `bodies`, a map by id, that is not static, with its predicted motion.
/// Throws Error (bad_predicted_state) where a state is wrong, or where there is not one for each moving body, by
/// ascending id.
template <class Bodies, class IsStatic, class Take>
void match_predicted(Bodies& bodies, const std::vector<PredictedState>& predicted, IsStatic is_static, Take take) {
  auto next = predicted.begin();
  for (auto& [id, entry] : bodies) {
    if (is_static(entry)) continue;
    if (next == predicted.end() || next->id > id) reject_predicted(id, "is missing; give one for each moving body");
    if (next->id < id) break;
    check_predicted(*next);
    take(entry, next->motion);
    ++next;
  }
  if (next != predicted.end())
    reject_predicted(next->id, "names no moving body, or comes twice or out of order; give one each, by ascending id");
}
/// Checks that a window [s] is positive and finite. Throws Error (bad_predicted_state).
void check_window(double window_s);
/// Checks friction and restitution. Throws Error (bad_contact_law).
void check_laws(const std::vector<ContactLaw>& laws);

/// Throws Error (bad_joint) with id, name and bodies of the joint.
[[noreturn]] void reject_joint(const Joint& joint, const std::string& what);
/// Checks id, kind and frames, and that the two bodies differ. Throws Error (bad_joint).
void check_joint(const Joint& joint);

}  // namespace sunder::rigid
