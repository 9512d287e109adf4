#pragma once
// Bodies that follow a prescribed motion or change their shape.
#include <memory>

#include "coupler/scene/load.h"
#include "shell/io/build.h"

namespace sunder::shell {

/// Makes the motion of body `body` of the scene, and places it at time 0. Null: impulses move it. `field` is the
/// body's; no shell of the scene takes windows shorter than some `least_window` [s]. Throws Error at the place where it
/// moves too far in a window.
std::shared_ptr<const DrivenMotion> make_driven(const scene::LoadedScene& scene, const std::string& field,
                                                const proto::Body& message, double least_window, RigidBody& body);

/// Gives driven bodies the mass at which engines see them: so large that nothing else moves them.
void set_driven_masses(RunSetup& setup);

}  // namespace sunder::shell
