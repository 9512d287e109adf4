#pragma once
// Writes VTK XML poly data with raw appended arrays, as ParaView reads it.
#include <string>
#include <vector>

#include "coupler/core/vec.h"

namespace sunder::shell {

struct VtpArray {
  std::string name;
  int components = 1;
  std::vector<double> values;
  bool integer = false;                        // written as integers of 64 bits
  std::string unit{};                          // UNITS_LABEL of the array
  std::vector<std::string> component_names{};  // empty: VTK's own
};

struct VtpMesh {
  std::vector<Vec3> points;
  std::vector<std::vector<int>> polygons, lines;
  std::vector<int> verts{};  // points that are cells; they come before lines and polygons
  std::vector<VtpArray> point_data, cell_data;
  double time = 0.0;                       // [s], in the field data
  std::vector<std::string> shell_names{};  // by their number in the cell array `shell`; empty: not written
  std::vector<double> shell_areas{};       // of the same shells now, cracked or not, as they are drawn [m^2]
};

/// Writes the mesh. Throws Error (bad_output) where the file cannot be written completely.
void write_vtp(const std::string& path, const VtpMesh& mesh);

/// Replaces a file atomically: a reader sees the old or the new text, never a part.
void write_atomically(const std::string& path, const std::string& text);

}  // namespace sunder::shell
