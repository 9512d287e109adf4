#pragma once
// A shell of a scene: patch, supports and loads.
#include "coupler/scene/load.h"
#include "shell/solver/model.h"

namespace sunder::shell {

/// Returns the material of that name, or nullptr.
const proto::Material* find_material(const proto::Scene& scene, const std::string& name);

class CadFiles;

/// Builds the model of a shell; `field` is the shell's field in the scene, `files` are the CAD files of the scene,
/// `part` counts the parts of a CAD face that is divided. Throws Error with the field where the patch, a support or a
/// load is wrong.
ShellModel build_shell(const scene::LoadedScene& scene, const proto::Shell& shell, const std::string& field,
                       CadFiles& files, int part);

/// The patch of a shell before trims move control points beside them; its parameters are lengths.
Patch whole_patch(const scene::LoadedScene& scene, const proto::Shell& shell, const std::string& field, CadFiles& files,
                  int part);

}  // namespace sunder::shell
