#pragma once
// What a STEP or IGES file holds, before there is a scene.
#include <string>

namespace sunder::shell {

/// Returns a JSON object: size and unit of the file, its faces with kind, area and loops, why a face would be refused,
/// and its edges. `element` [m] is the spacing of shells; 0: a fortieth of the file's size. Throws Error where the file
/// cannot be read.
std::string inspect_report(const std::string& file, double element);

}  // namespace sunder::shell
