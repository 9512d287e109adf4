#pragma once
// The copy of the scene in a run folder.
#include <string>

namespace sunder::shell {

/// Writes the scene as it is run, settings included, into a run folder. Pictures and exports take names and thickness
/// from there. Does nothing with an empty text. Throws Error (bad_output).
void write_scene_copy(const std::string& folder, const std::string& scene_text);

}  // namespace sunder::shell
