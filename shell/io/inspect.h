#pragma once
// What a STEP or IGES file holds, before there is a scene.
#include <string>

namespace sunder::shell {

/// Returns a JSON object: size and unit of the file, its faces with kind, area and loops, why a face would be refused,
/// and its edges. `element` [m] is the spacing of shells; 0: a fortieth of the file's size. `unit` [m] is that of a
/// file that says none; 0: the file's. `frame` is a folder for a frame of the shells; empty: none.
/// Throws Error where the file cannot be read, or has no unit.
std::string inspect_report(const std::string& file, double element, double unit = 0.0, const std::string& frame = "");

}  // namespace sunder::shell
