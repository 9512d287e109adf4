#include "shell/io/mesh_parts.h"

#include <cmath>
#include <numbers>

#include "coupler/scene/mesh.h"

namespace sunder::shell {
namespace {

constexpr double kDefaultCrease = 40.0;  // [deg]
constexpr double kDegreeOfMesh = std::numbers::pi / 180.0;

double crease_of(const proto::SurfaceMesh& m) { return m.has_crease_deg() ? m.crease_deg() : kDefaultCrease; }

}  // namespace

TriangleMesh read_shell_mesh(const scene::LoadedScene& scene, const std::string& field, const proto::SurfaceMesh& m,
                             int& faces) {
  scene::FileSurface file = scene::read_surface(scene, field, m.path(), m.has_unit_m() ? m.unit_m() : 1.0);
  faces = file.faces;
  if (m.up() == proto::SurfaceMesh::Y)
    for (Vec3& x : file.points) x = Vec3(x.x(), -x.z(), x.y());
  std::vector<FileTriangle> triangles;
  for (std::size_t t = 0; t < file.triangles.size(); ++t) triangles.push_back({file.triangles[t], file.lines[t]});
  try {
    return make_triangle_mesh(file.points, triangles, m.weld_m(), file.word);
  } catch (const Error& e) {
    scene.fail(field + ".path", fmt::format("'{}' {}", m.path(), e.what()));
  }
}

std::shared_ptr<const MeshShells> mesh_shells(const scene::LoadedScene& scene, const std::string& field,
                                              const proto::SurfaceMesh& m) {
  auto out = std::make_shared<MeshShells>();
  out->mesh = read_shell_mesh(scene, field, m, out->faces);
  try {
    out->charts = patches_of(out->mesh, {m.element_m(), crease_of(m) * kDegreeOfMesh, m.has_degree() ? m.degree() : 2});
  } catch (const Error& e) {
    scene.fail(field + ".path", fmt::format("'{}': {}", m.path(), e.what()));
  }
  for (const MeshPatch& p : out->charts.patches) {
    CadSurface& s = out->surfaces.emplace_back(CadSurface{p.patch, {}, p.area, p.error});
    for (const PatchLoop& loop : p.loops) {
      CadLoop& own = s.loops.emplace_back();
      own.hole = loop.hole;
      for (const PlaneCurve& curve : loop.curves) own.borders.push_back({curve, 0});
    }
  }
  return out;
}

const MeshShells& CadFiles::mesh(const scene::LoadedScene& scene, const std::string& field,
                                 const proto::SurfaceMesh& mesh) {
  std::shared_ptr<const MeshShells>& known = meshes_[mesh.SerializeAsString()];
  if (!known) known = mesh_shells(scene, field, mesh);
  return *known;
}

void check_one_patch(const scene::LoadedScene& scene, const proto::Shell& s, const std::string& field, int charts) {
  if (charts < 2) return;
  const auto refuse = [&](bool given, const std::string& own, const char* remedy) {
    scene.check(!given, field + "." + own,
                "is for a shell of one patch, and the mesh becomes {} shells, {}.1 to {}.{}; {}", charts, s.name(),
                s.name(), charts, remedy);
  };
  refuse(s.supports_size() > 0, "supports", "leave supports out, or let the shell rest on bodies");
  refuse(s.cuts_size() > 0, "cuts", "leave cuts out");
  refuse(s.trims_size() > 0, "trims", "leave trims out, and cut the mesh in the program that made it");
  refuse(s.strength_regions_size() > 0, "strength_regions", "leave them out");
  refuse(s.has_strength_map(), "strength_map", "leave it out");
  refuse(s.strength_lines_size() > 0, "strength_lines",
         "leave them out, or give strength_lines of the scene, in space");
  for (int i = 0; i < s.loads_size(); ++i)
    refuse(s.loads(i).has_point() || s.loads(i).has_edge_force() || s.loads(i).has_edge_moment(),
           fmt::format("loads[{}]", i), "leave it out, or give a pressure");
}

std::vector<KnownBorder> mesh_borders(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts,
                                      CadFiles& files) {
  std::vector<KnownBorder> out;
  for (std::size_t first = 0; first < parts.size();) {
    std::size_t end = first + 1;
    while (end < parts.size() && parts[end].shell == parts[first].shell) ++end;
    if (parts[first].message.has_mesh()) {
      const MeshShells& mesh =
          files.mesh(scene, fmt::format("shells[{}].mesh", parts[first].shell), parts[first].message.mesh());
      for (const MeshSeam& seam : mesh.charts.seams) {
        out.push_back({static_cast<int>(first) + seam.first, static_cast<int>(first) + seam.second, seam.on_first,
                       seam.on_second, seam.closed, !seam.crease});
      }
    }
    first = end;
  }
  return out;
}

}  // namespace sunder::shell
