#pragma once
// VTK XML poly data with raw appended arrays, as ParaView reads it.
#include <string>
#include <vector>

#include "coupler/core/vec.h"

namespace sunder::shell {

struct VtpArray {
  std::string name;
  int components = 1;
  std::vector<double> values;
};

struct VtpMesh {
  std::vector<Vec3> points;
  std::vector<std::vector<int>> polygons, lines;
  std::vector<int> verts{};  // points that are cells, before lines and polygons
  std::vector<VtpArray> point_data, cell_data;
};

/// Throws Error (bad_output) where the file cannot be written whole.
void write_vtp(const std::string& path, const VtpMesh& mesh);

/// Replaces a file at once: readers see the old or the new text, never half.
void write_atomically(const std::string& path, const std::string& text);

}  // namespace sunder::shell
