#pragma once
// Names of shells in a scene, where CAD faces divide a shell into several of the run.
#include "shell/io/cad_parts.h"

namespace sunder::shell {

/// The shells of the run that `name` means: one, or all that CAD faces make of one shell of the scene; none where it
/// names no shell. Throws Error at `field` where NAME.5 is named and there are fewer.
std::vector<int> shells_named(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts,
                              const std::string& field, const std::string& name);

/// The one shell that `name` means. Throws Error at `field` where it means several, with their names.
int shell_named(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, const std::string& field,
                const std::string& name);

/// Throws Error where a rule, a probe or a launch names shells that the files do not have.
void check_names(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts);

}  // namespace sunder::shell
