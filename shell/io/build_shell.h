#pragma once
// A shell of a scene: patch, supports and loads.
#include "coupler/scene/load.h"
#include "shell/solver/model.h"

namespace sunder::shell {

/// Returns the material of that name, or nullptr.
const proto::Material* find_material(const proto::Scene& scene, const std::string& name);

/// Builds the model of a shell; `field` is the shell's field in the scene. Throws Error with the field where the patch,
/// a support or a load is wrong.
ShellModel build_shell(const scene::LoadedScene& scene, const proto::Shell& shell, const std::string& field);

}  // namespace sunder::shell
