#pragma once
// Checks that all engines share. For adapters.
#include "rigid/engine/engine.h"

namespace sunder::rigid {

/// Throws Error (bad_body) with id, name and field of the body. `what`: value and remedy.
[[noreturn]] void reject_body(const RigidBody& body, const std::string& field, const std::string& what);
/// Throws Error (bad_handback) for the predicted state of a body.
[[noreturn]] void reject_predicted(BodyId id, const std::string& what);
/// Checks id, motion, sizes of the shape, mass and inertia. Corners of convex parts are checked elsewhere. Throws Error
/// (bad_body) with id, name, value and remedy.
void check_body(const RigidBody& body);
/// Checks that a predicted state is finite and its quaternion has length 1. Throws Error (bad_handback).
void check_predicted(const PredictedState& predicted);
/// Checks that a window [s] is positive and finite. Throws Error (bad_handback).
void check_window(double window_s);
/// Checks friction and restitution. Throws Error (bad_contact_law).
void check_laws(const std::vector<ContactLaw>& laws);

/// Throws Error (bad_joint) with id, name and bodies of the joint.
[[noreturn]] void reject_joint(const Joint& joint, const std::string& what);
/// Checks id, kind and frames, and that the two bodies differ. Throws Error (bad_joint).
void check_joint(const Joint& joint);

}  // namespace sunder::rigid
