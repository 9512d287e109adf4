#pragma once
// What every engine refuses. For adapters.
#include "rigid/engine/engine.h"

namespace sunder::rigid {

/// Throws Error (bad_body).
[[noreturn]] void reject_body(const RigidBody& body, const std::string& field, const std::string& what);
/// Throws Error (bad_handback).
[[noreturn]] void reject_predicted(BodyId id, const std::string& what);
/// Id, motion, sizes of its shape (corners of convex parts left out), mass and inertia. Throws Error (bad_body) with
/// id, name, value and remedy.
void check_body(const RigidBody& body);
/// Finite, unit quaternion. Throws Error (bad_handback).
void check_predicted(const PredictedState& predicted);
/// Throws Error (bad_handback).
void check_window(double window_s);
/// Throws Error (bad_contact_law).
void check_laws(const std::vector<ContactLaw>& laws);

/// Throws Error (bad_joint).
[[noreturn]] void reject_joint(const Joint& joint, const std::string& what);
/// Id, frames, and two ends that differ. Throws Error (bad_joint).
void check_joint(const Joint& joint);

}  // namespace sunder::rigid
