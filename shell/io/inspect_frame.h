#pragma once
// Shells of a file as a frame, for pictures of what `inspect` sees.
#include <string>

#include "shell/io/build.h"

namespace sunder::shell {

/// Writes the shells of a setup at rest as the only frame of a folder; each shell is a piece of its own. Throws Error
/// (bad_output).
void write_frame_of(const RunSetup& setup, const std::string& folder);

}  // namespace sunder::shell
