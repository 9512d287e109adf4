#pragma once
// What a mesh file holds, and the shells that it would become.
#include <string>

namespace sunder::shell {

/// Whether the name is that of a mesh file, by its end.
bool is_mesh_file(const std::string& file);

/// As JSON: counts, borders, size, area, and charts with size, stretch, error and stable step. `element` [m] is their
/// spacing; 0: a fortieth of the file's size. What a scene would be refused for is its member "refused". Throws Error
/// where the file cannot be read.
std::string inspect_mesh_report(const std::string& file, double element);

}  // namespace sunder::shell
