#include "shell/io/inspect_mesh.h"

#include <algorithm>
#include <filesystem>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "coupler/scene/mesh_reader.h"
#include "shell/io/build.h"
#include "shell/io/element_fit.h"
#include "shell/io/inspect_frame.h"
#include "shell/io/mesh_parts.h"

namespace sunder::shell {
namespace {

using MeshJson = nlohmann::ordered_json;

constexpr double kMeshElements = 40.0;       // along the diagonal of a file, by default
constexpr double kMeshThickness = 0.2;       // of an element: any thickness does
constexpr std::size_t kMostBorders = 20000;  // edges of borders that are listed

scene::LoadedScene mesh_scene(const std::string& file, const MeshQuestion& asked) {
  scene::LoadedScene scene;
  const std::filesystem::path path = std::filesystem::absolute(file);
  scene.path = path.parent_path() / "inspect.textproto";
  scene.message.set_end_time_s(1.0), scene.message.set_window_s(1e-3);
  proto::Material& material = *scene.message.add_materials();
  material.set_name("steel"), material.set_density(7800.0);
  material.set_youngs_modulus(2e11), material.set_poisson_ratio(0.3);
  proto::Shell& shell = *scene.message.add_shells();
  shell.set_name("part"), shell.set_material("steel"), shell.set_thickness_m(kMeshThickness * asked.element);
  proto::SurfaceMesh& mesh = *shell.mutable_mesh();
  mesh.set_path(path.filename()), mesh.set_element_m(asked.element);
  mesh.set_unit_m(asked.unit), mesh.set_weld_m(asked.weld);
  return scene;
}

// The message of an Error without file and field, which belong to no scene of the user's.
std::string mesh_problem(const scene::LoadedScene& scene, const Error& e) {
  std::string text = e.what();
  const std::string quoted = "'" + scene.message.shells(0).mesh().path() + "'";
  for (const std::string& head : {scene.path + ": ", e.field + ": ", quoted + ": ", quoted + " "})
    if (text.rfind(head, 0) == 0) text.erase(0, head.size());
  return text;
}

MeshJson named_json(const std::vector<NamedFaces>& list) {
  MeshJson out = MeshJson::array();
  for (const NamedFaces& n : list) out.push_back({{"name", n.name}, {"triangles", n.triangles}});
  return out;
}

// Edges on borders, those of large meshes up to kMostBorders.
MeshJson borders_of(const TriangleMesh& mesh) {
  MeshJson out = MeshJson::array();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      if (mesh.beside[t][k] >= 0 || out.size() >= kMostBorders) continue;
      const Vec3 &a = mesh.points[mesh.triangles[t][k]], &b = mesh.points[mesh.triangles[t][(k + 1) % 3]];
      out.push_back({{a.x(), a.y(), a.z()}, {b.x(), b.y(), b.z()}});
    }
  return out;
}

MeshJson chart_of(const ShellModel& m, const MeshPatch& p, double element) {
  const auto holes = std::count_if(p.loops.begin(), p.loops.end(), [](const PatchLoop& l) { return l.hole; });
  double area = 0.0;
  for (const double part : m.mass) area += part / (m.material.density * m.thickness);
  const ElementFit fit = element_fit(m, element);
  return {
      {"shell", m.name},
      {"triangles", p.triangles},
      {"width_m", {m.patch.knots_u.end() - m.patch.knots_u.begin(), m.patch.knots_v.end() - m.patch.knots_v.begin()}},
      {"elements", {m.tables.spans_u, m.tables.spans_v}},
      {"area_m2", p.area},
      {"area_of_shell_m2", area},
      {"stretch", p.stretch},
      {"error_m", p.error},
      {"trimmed", static_cast<std::ptrdiff_t>(p.loops.size()) > holes},
      {"holes", holes},
      {"stable_step_s", fit.step},
      {"warning", fit.warning.empty() ? MeshJson() : MeshJson(fit.warning)}};
}

}  // namespace

bool is_mesh_file(const std::string& file) {
  const std::string end = scene::mesh_suffix(file);
  return end == ".obj" || end == ".off" || end == ".ply" || end == ".stl" || end == ".glb" || end == ".gltf";
}

std::string inspect_mesh_report(const std::string& file, MeshQuestion asked, const std::string& frame) {
  const scene::LoadedScene first = mesh_scene(file, asked);
  ShellMesh read;
  try {
    read = read_shell_mesh(first, "shells[0].mesh", first.message.shells(0).mesh());
  } catch (const Error& e) {
    Error plain(e.status, "bad_input", file + ": " + mesh_problem(first, e));
    plain.file = file;
    throw plain;
  }
  const TriangleMesh& mesh = read.mesh;
  Eigen::AlignedBox3d box;
  for (const Vec3& x : mesh.points) box.extend(x);
  if (asked.element <= 0.0) asked.element = box.diagonal().norm() / kMeshElements;
  double area = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) area += mesh.area(static_cast<int>(t));
  const MeshEdges edges = edges_of(mesh);
  const Vec3 low = box.min(), size = box.sizes();
  const scene::LoadedScene scene = mesh_scene(file, asked);
  const std::string warning =
      asked.has_unit ? "" : unit_warning(scene.message.shells(0).mesh().path(), size.maxCoeff(), "--unit");
  MeshJson out = {{"file", file},
                  {"low_m", {low.x(), low.y(), low.z()}},
                  {"size_m", {size.x(), size.y(), size.z()}},
                  {"element_m", asked.element},
                  {"unit_m", asked.unit},
                  {"weld_m", asked.weld},
                  {"warning", warning.empty() ? MeshJson() : MeshJson(warning)},
                  {"thickness_m", scene.message.shells(0).thickness_m()},
                  {"faces", read.faces},
                  {"points", mesh.points.size()},
                  {"triangles", mesh.triangles.size()},
                  {"points_merged", mesh.welded},
                  {"points_parted", mesh.parted},
                  {"triangles_turned", mesh.turned},
                  {"triangles_dropped", mesh.dropped},
                  {"components", mesh.components},
                  {"edges", {{"all", edges.all}, {"on_borders", edges.border}, {"borders", edges.loops}}},
                  {"borders_m", borders_of(mesh)},
                  {"area_m2", area},
                  {"groups", named_json(read.groups)},
                  {"usemtl", named_json(read.usemtl)},
                  {"coloured", !read.colours.empty()},
                  {"charts", MeshJson::array()},
                  {"seams", nullptr},
                  {"refused", nullptr}};
  try {
    CadFiles files;
    const MeshShells& shells = files.mesh(scene, "shells[0].mesh", scene.message.shells(0));
    const RunSetup setup = build(scene);
    if (!frame.empty()) write_frame_of(setup, frame);
    for (std::size_t k = 0; k < setup.shells.size(); ++k)
      out["charts"].push_back(chart_of(setup.shells[k].model, shells.charts.patches[k], asked.element));
    int smooth = 0;
    for (const Seam& s : setup.stitches.seams) smooth += s.smooth;
    out["seams"] = {{"joined", setup.stitches.seams.size()}, {"smooth", smooth}};
  } catch (const Error& e) {
    out["refused"] = mesh_problem(scene, e);
  }
  return out.dump(1) + "\n";
}

}  // namespace sunder::shell
