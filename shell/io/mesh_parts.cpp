#include "shell/io/mesh_parts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "coupler/core/nearest.h"
#include "coupler/scene/mesh.h"
#include "shell/io/reference_surface.h"
#include "shell/io/thickness_factors.h"

namespace sunder::shell {
namespace {

constexpr double kDefaultCrease = 40.0;                // [deg]
constexpr std::size_t kMostListed = 20;                // names in a message
constexpr double kLeastMesh = 1e-3, kMostMesh = 10.0;  // [m]: beyond, a unit may have been forgotten
constexpr double kDegreeOfMesh = std::numbers::pi / 180.0;

double crease_of(const proto::SurfaceMesh& m) { return m.has_crease_deg() ? m.crease_deg() : kDefaultCrease; }

void count_named(std::vector<NamedFaces>& list, const std::string& name) {
  const auto known = std::find_if(list.begin(), list.end(), [&](const NamedFaces& n) { return n.name == name; });
  (known == list.end() ? list.emplace_back(NamedFaces{name}) : *known).triangles += 1;
}

bool is_in_part(const scene::FaceTag& tag, const proto::MeshPart& part) {
  if (part.group().empty()) return tag.usemtl == part.usemtl();
  return std::find(tag.groups.begin(), tag.groups.end(), part.group()) != tag.groups.end();
}

// Throws Error where the file has no faces of such a name.
void check_named(const scene::LoadedScene& scene, const std::string& field, const proto::SurfaceMesh& m,
                 const proto::MeshPart& part, const ShellMesh& read) {
  const bool by_group = !part.group().empty();
  const std::string &name = by_group ? part.group() : part.usemtl(), own = field + (by_group ? ".group" : ".usemtl");
  const char* kind = by_group ? "group" : "usemtl";
  std::vector<std::string> names;
  for (const NamedFaces& n : by_group ? read.groups : read.usemtl) names.push_back(n.name);
  if (std::find(names.begin(), names.end(), name) != names.end()) return;
  scene.check(!names.empty(), own, "is '{}', and no face of '{}' has a {}; {}", name, m.path(), kind,
              read.groups.empty() && read.usemtl.empty()
                  ? "export an OBJ file with groups or materials, or leave the part out"
              : by_group ? "name a usemtl, or export groups"
                         : "name a group, or export materials");
  const std::string has = nearest_names(name, names).empty() ? "it has" : did_you_mean(name, names) + " It has";
  const std::size_t more = names.size() > kMostListed ? names.size() - kMostListed : 0;
  names.resize(names.size() - more);
  scene.fail(own, fmt::format("is '{}', which is no {} of '{}'; {}: {}{}", name, kind, m.path(), has,
                              fmt::join(names, ", "), more > 0 ? fmt::format(" and {} more", more) : ""));
}

// The part of each face of a file: the number in the scene's list, from 1; 0: none.
std::vector<int> parts_of_faces(const scene::LoadedScene& scene, const std::string& field, const proto::SurfaceMesh& m,
                                const scene::FileSurface& file, const ShellMesh& read) {
  for (int k = 0; k < m.parts_size(); ++k)
    check_named(scene, fmt::format("{}.parts[{}]", field, k), m, m.parts(k), read);
  std::vector<int> of_tag(file.tags.size(), 0), out(file.triangles.size(), 0);
  for (std::size_t t = 0; t < file.triangles.size(); ++t) {
    if (file.tag_of[t] < 0) continue;
    int& part = of_tag[file.tag_of[t]];
    for (int k = 0; k < m.parts_size() && part == 0; ++k) {
      if (!is_in_part(file.tags[file.tag_of[t]], m.parts(k))) continue;
      part = k + 1;
      for (int i = k + 1; i < m.parts_size(); ++i)
        scene.check(!is_in_part(file.tags[file.tag_of[t]], m.parts(i)), fmt::format("{}.parts[{}]", field, i),
                    "names the face of {} {} of '{}', which parts[{}] names too; give each face one part", file.word,
                    file.lines[t], m.path(), k);
    }
    out[t] = part;
  }
  return out;
}

// Factors of a paint at points of the mesh.
template <class PaintMessage>
std::vector<double> factors_of(const scene::LoadedScene& scene, const std::string& field, const proto::SurfaceMesh& m,
                               const PaintMessage& paint, const ShellMesh& read) {
  scene.check(
      !read.colours.empty(), field,
      "is given, and points of '{}' have no colours; export a PLY, OBJ or glTF file with colours of points, or leave "
      "it out",
      m.path());
  const double low = paint.low_factor(), high = paint.has_high_factor() ? paint.high_factor() : 1.0;
  std::vector<double> out;
  for (const int k : read.mesh.of_file) {
    const Vec3& rgb = read.colours[k];
    scene.check(rgb.allFinite(), field, "is given, and point {} of '{}', counted from 1, has no colour; paint all",
                k + 1, m.path());
    scene.check(rgb.minCoeff() >= 0.0 && rgb.maxCoeff() <= 1.0, field,
                "is given, and point {} of '{}', counted from 1, has the colour ({:.6g}, {:.6g}, {:.6g}); 0 to 1, or "
                "whole numbers up to 255 in a PLY file",
                k + 1, m.path(), rgb.x(), rgb.y(), rgb.z());
    const double share = paint.channel() == proto::StrengthPaint::GREY ? rgb.mean() : rgb[paint.channel() - 1];
    out.push_back(low + (high - low) * share);
  }
  return out;
}

}  // namespace

ShellMesh read_shell_mesh(const scene::LoadedScene& scene, const std::string& field, const proto::SurfaceMesh& m) {
  scene::FileSurface file = scene::read_surface(scene, field, m.path(), m.has_unit_m() ? m.unit_m() : 1.0);
  ShellMesh out;
  out.faces = file.faces, out.colours = file.colours;
  for (const int tag : file.tag_of) {
    if (tag < 0) continue;
    for (const std::string& name : file.tags[tag].groups) count_named(out.groups, name);
    if (!file.tags[tag].usemtl.empty()) count_named(out.usemtl, file.tags[tag].usemtl);
  }
  const std::vector<int> parts = parts_of_faces(scene, field, m, file, out);
  if (m.up() == proto::SurfaceMesh::Y)
    for (Vec3& x : file.points) x = Vec3(x.x(), -x.z(), x.y());
  std::vector<FileTriangle> triangles;
  for (std::size_t t = 0; t < file.triangles.size(); ++t)
    triangles.push_back({file.triangles[t], file.lines[t], parts[t]});
  try {
    out.mesh = make_triangle_mesh(file.points, triangles, m.weld_m(), file.word);
  } catch (const Error& e) {
    scene.fail(field + ".path", fmt::format("'{}' {}", m.path(), e.what()));
  }
  for (const auto& corners : out.mesh.corner_of_file)
    for (std::size_t k = 0; k < corners.size() && !file.texture.empty(); ++k)
      out.texture.push_back(file.texture[corners[k]]);
  return out;
}

std::function<Vec2(const Vec2&)> MeshShells::texture_map(int chart) const {
  const std::vector<PlacedTriangle>& placed = charts.patches[chart].placed;
  const auto has = [&](const PlacedTriangle& t) {
    return std::none_of(&texture[0][3 * t.triangle], &texture[0][3 * t.triangle] + 3,
                        [](double u) { return std::isnan(u); });
  };
  if (texture[0].empty() || placed.empty() || !std::all_of(placed.begin(), placed.end(), has)) return {};
  const std::array<Paint, 2> along{Paint::of_corners(placed, texture[0]), Paint::of_corners(placed, texture[1])};
  return [along](const Vec2& p) { return Vec2(along[0].at(p), along[1].at(p)); };
}

std::function<Vec3(const Vec2&)> MeshShells::colour_map(int chart) const {
  const std::vector<PlacedTriangle>& placed = charts.patches[chart].placed;
  const auto has = [&](const PlacedTriangle& t) {
    return std::none_of(t.points.begin(), t.points.end(), [&](int k) { return std::isnan(colours[0][k]); });
  };
  if (colours[0].empty() || placed.empty() || !std::all_of(placed.begin(), placed.end(), has)) return {};
  const std::array<Paint, 3> rgb{Paint(placed, colours[0]), Paint(placed, colours[1]), Paint(placed, colours[2])};
  return [rgb](const Vec2& p) { return Vec3(rgb[0].at(p), rgb[1].at(p), rgb[2].at(p)); };
}

std::string unit_warning(const std::string& path, double size, const std::string& option) {
  if (size >= kLeastMesh && size <= kMostMesh) return "";
  return fmt::format("'{}' is taken in metres, {:.3g} m long, as no {} is given; give 0.001 for millimetres, or 1",
                     path, size, option);
}

std::string touching_warning(const std::string& shell, const std::string& path, const TriangleMesh& mesh) {
  const Vec3& x = mesh.first_parted;
  return fmt::format(
      "shell '{}': the surface of '{}' touches itself in {} point{}, the first at ({:.6g}, {:.6g}, {:.6g}) m before "
      "its pose, and bears no load from one sheet to the other there; where sheets should join along an edge from it, "
      "give a weld_m that is wider than the gap between them",
      shell, path, mesh.parted, mesh.parted == 1 ? "" : "s", x.x(), x.y(), x.z());
}

proto::Shell shell_of_chart(const proto::Shell& shell, const MeshShells& mesh, int chart) {
  proto::Shell out = shell;
  const int part = mesh.charts.patches[chart].part;
  if (part == 0) return out;
  const proto::MeshPart& own = shell.mesh().parts(part - 1);
  if (!own.material().empty()) out.set_material(own.material());
  if (own.has_thickness_m()) out.set_thickness_m(own.thickness_m());
  return out;
}

namespace {

// Moves the face of a sheet that a file gives to the middle.
void move_to_middle(const scene::LoadedScene& scene, const std::string& field, const proto::Shell& shell,
                    MeshShells& out) {
  const proto::SurfaceMesh& m = shell.mesh();
  const double side = shell.reference() == proto::Shell::OUTSIDE ? -0.5 : 0.5;
  const Vec3 position = scene::to_vec(m.pose().position());
  const Quat turn = scene::to_quat(m.pose());
  const auto distance = [&](int point, int part) {
    const bool own = part > 0 && m.parts(part - 1).has_thickness_m();
    double thickness = own ? m.parts(part - 1).thickness_m() : shell.thickness_m();
    if (!out.thickness.empty()) thickness *= out.thickness[point];
    if (shell.has_thickness_law()) {
      const Vec3 place = position + turn * out.mesh.points[point];
      thickness *= law_factor(shell.thickness_law(), place);
    }
    return side * thickness;
  };
  try {
    offset_mesh(out.mesh, distance);
  } catch (const Error& e) {
    scene.fail(field.substr(0, field.rfind('.')) + ".reference", fmt::format("'{}' {}", m.path(), e.what()));
  }
}

}  // namespace

std::shared_ptr<const MeshShells> mesh_shells(const scene::LoadedScene& scene, const std::string& field,
                                              const proto::Shell& shell) {
  const proto::SurfaceMesh& m = shell.mesh();
  auto out = std::make_shared<MeshShells>();
  ShellMesh read = read_shell_mesh(scene, field, m);
  if (m.has_strength_paint()) out->factors = factors_of(scene, field + ".strength_paint", m, m.strength_paint(), read);
  if (m.has_thickness_paint())
    out->thickness = factors_of(scene, field + ".thickness_paint", m, m.thickness_paint(), read);
  out->mesh = std::move(read.mesh);
  for (const Vec2& uv : read.texture) out->texture[0].push_back(uv.x()), out->texture[1].push_back(uv.y());
  for (std::size_t k = 0; k < out->mesh.of_file.size() && !read.colours.empty(); ++k)
    for (int d = 0; d < 3; ++d) out->colours[d].push_back(read.colours[out->mesh.of_file[k]][d]);
  if (shell.reference() != proto::Shell::MIDDLE) move_to_middle(scene, field, shell, *out);
  const bool painted = m.has_strength_paint() || m.has_thickness_paint();
  try {
    out->charts = patches_of(out->mesh, {m.element_m(), crease_of(m) * kDegreeOfMesh, m.has_degree() ? m.degree() : 2,
                                         out->mesh.part, painted || !read.texture.empty() || !read.colours.empty()});
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

const MeshShells& CadFiles::mesh(const scene::LoadedScene& scene, const std::string& field, const proto::Shell& shell) {
  const std::string name = shell.name().substr(0, shell.name().find('.'));
  const auto& all = scene.message.shells();
  const auto own = std::find_if(all.begin(), all.end(), [&](const proto::Shell& s) { return s.name() == name; });
  proto::Shell key;
  *key.mutable_mesh() = shell.mesh();
  if (shell.reference() != proto::Shell::MIDDLE) {  // then the surface depends on the thickness
    key.set_reference(shell.reference()), key.set_thickness_m(own->thickness_m());
    if (shell.has_thickness_law()) *key.mutable_thickness_law() = shell.thickness_law();
  }
  std::shared_ptr<const MeshShells>& known = meshes_[key.SerializeAsString()];
  if (!known) known = mesh_shells(scene, field, key);
  return *known;
}

void check_one_patch(const scene::LoadedScene& scene, const proto::Shell& s, const std::string& field, int charts) {
  if (charts < 2) return;
  const auto refuse = [&](bool given, const std::string& own, const char* remedy) {
    scene.check(!given, field + "." + own,
                "is for a shell of one patch, and the mesh becomes {} shells, {}.1 to {}.{}; {}", charts, s.name(),
                s.name(), charts, remedy);
  };
  for (int i = 0; i < s.supports_size(); ++i)
    refuse(s.supports(i).edges_size() + s.supports(i).corners_size() + s.supports(i).regions_size() > 0,
           fmt::format("supports[{}]", i), "give boxes, which are places in space");
  for (int i = 0; i < s.cuts_size(); ++i)
    refuse(!s.cuts(i).has_line(), fmt::format("cuts[{}]", i), "give a line, whose points are places in space");
  refuse(s.trims_size() > 0, "trims", "leave trims out, and cut the mesh in the program that made it");
  refuse(s.strength_regions_size() > 0, "strength_regions", "leave them out");
  refuse(s.has_strength_map(), "strength_map", "leave it out");
  refuse(s.has_thickness_map(), "thickness_map", "leave it out, or give thickness_paint");
  refuse(s.has_thickness_law() && s.thickness_law().along() < proto::ThicknessLaw::X, "thickness_law.along",
         "take X, Y or Z, which are the world's");
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
          files.mesh(scene, fmt::format("shells[{}].mesh", parts[first].shell), parts[first].message);
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
