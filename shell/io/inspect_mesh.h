#pragma once
// What a mesh file holds, and the shells that it would become.
#include <string>

namespace sunder::shell {

/// Whether the name is that of a mesh file, by its end.
bool is_mesh_file(const std::string& file);

/// What is asked of a mesh, as in a scene.
struct MeshQuestion {
  double element = 0.0;   // spacing [m]; 0: a fortieth of the file's size
  double unit = 1.0;      // of the file [m]
  double weld = 0.0;      // points no further apart become one [m]
  bool has_unit = false;  // whether `unit` was given
};

/// As JSON: counts, borders, size, area, and charts with size, stretch, error and stable step. What a scene would be
/// refused for is its member "refused". Throws Error where the file cannot be read.
std::string inspect_mesh_report(const std::string& file, MeshQuestion asked, const std::string& frame = "");

}  // namespace sunder::shell
