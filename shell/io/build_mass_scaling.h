#pragma once
// The mass that a scene lets small elements have.
#include "coupler/scene/load.h"
#include "shell/io/build.h"

namespace sunder::shell {

/// Adds mass to the shells of `setup` until their stable step is what the scene asks for, and notes what that does in
/// setup.mass_scaling. Call it last: it needs seams and what may crack. Throws Error at the scene's field where a shell
/// can crack, the step is not reached, or the mass or the error of a frequency is above its bound; it then says which
/// step would pass.
void scale_masses(const scene::LoadedScene& scene, RunSetup& setup);

}  // namespace sunder::shell
