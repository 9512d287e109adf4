#pragma once
// Shells of a mesh file: a chart each.
#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "coupler/scene/load.h"
#include "shell/geometry/trim_seams.h"
#include "shell/io/cad_file.h"
#include "shell/io/cad_parts.h"
#include "shell/meshes/mesh_patches.h"

namespace sunder::shell {

/// A mesh that has been read, as patches where the file has it.
struct MeshShells {
  TriangleMesh mesh;
  MeshPatches charts;
  std::vector<CadSurface> surfaces;  // [chart]
  std::vector<double> factors;       // of the strength at each point of the mesh; empty: no paint
  std::vector<double> thickness;     // the same of the thickness
  // Texture coordinates of corner k of triangle t of the mesh, at 3 t + k; empty: the file has none.
  std::array<std::vector<double>, 2> texture;
  // Red, green and blue of each point of the mesh, 1 is full, NaN: none; empty: the file has none.
  std::array<std::vector<double>, 3> colours;

  /// Factors of the strength over a chart.
  Paint paint(int chart) const { return {charts.patches[chart].placed, factors}; }
  Paint thickness_paint(int chart) const { return {charts.patches[chart].placed, thickness}; }
  /// Texture coordinates over a chart by its parameters; null where the file has none for a face of the chart.
  std::function<Vec2(const Vec2&)> texture_map(int chart) const;
  /// Colours over a chart by its parameters, linear on each triangle; null where a point of the chart has none.
  std::function<Vec3(const Vec2&)> colour_map(int chart) const;
};

/// Faces of a file with a name.
struct NamedFaces {
  std::string name;
  int triangles = 0;
};

/// A mesh that has been read, without its charts.
struct ShellMesh {
  TriangleMesh mesh;
  int faces = 0;                           // of the file
  std::vector<NamedFaces> groups, usemtl;  // of an OBJ file, in its order
  std::vector<Vec3> colours;               // as FileSurface has them
  std::vector<Vec2> texture;               // as MeshShells, NaN: none
};

/// Reads the file, with `up` and unit applied, but not the pose. `field` is that of the mesh. Throws Error with file,
/// place and remedy where the surface is no shell, or has no such parts.
ShellMesh read_shell_mesh(const scene::LoadedScene& scene, const std::string& field, const proto::SurfaceMesh& mesh);

/// Warning where a mesh for which no unit is given is above 10 m or below 1 mm long; else empty. `size` is its longest
/// side [m], `option` what gives the unit.
std::string unit_warning(const std::string& path, double size, const std::string& option);

/// Warning of a surface that touches itself in points, in which its sheets are parted. `shell` is its name.
std::string touching_warning(const std::string& shell, const std::string& path, const TriangleMesh& mesh);

/// The shell of a chart: that of the scene with what its part of the mesh has of its own.
proto::Shell shell_of_chart(const proto::Shell& shell, const MeshShells& mesh, int chart);

/// The shells of the mesh of a shell, of which mesh, reference, thickness and its law count. Throws Error as
/// read_shell_mesh, and where no patches can be fitted.
std::shared_ptr<const MeshShells> mesh_shells(const scene::LoadedScene& scene, const std::string& field,
                                              const proto::Shell& shell);

/// Throws Error where a shell of several charts has what is for one patch only. `field` is the shell's.
void check_one_patch(const scene::LoadedScene& scene, const proto::Shell& shell, const std::string& field, int charts);

/// Borders of charts along which the shells of meshes meet.
std::vector<KnownBorder> mesh_borders(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts,
                                      CadFiles& files);

}  // namespace sunder::shell
