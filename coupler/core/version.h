#pragma once

namespace sunder {

/// Of the project, as project() in the root CMakeLists.txt has it, e.g. "0.9.0".
const char* version();

}  // namespace sunder
