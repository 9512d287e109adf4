// Checks meshes that become shells: their parts and their paint.
#include <algorithm>
#include <cmath>

#include "coupler/scene/checks.h"
#include "coupler/scene/mesh_reader.h"
#include "coupler/scene/names.h"

namespace sunder::scene {
namespace {

void surface_mesh(const LoadedScene& s, const std::string& f, const proto::SurfaceMesh& m) {
  s.check(!m.path().empty(), f + ".path",
          "is missing; name an .obj, .off, .ply, .stl, .glb or .gltf file beside the scene");
  if (m.has_unit_m()) positive(s, f + ".unit_m", true, m.unit_m(), "m");
  positive(s, f + ".element_m", m.has_element_m(), m.element_m(), "m");
  s.check(!m.has_crease_deg() || (m.crease_deg() >= 5.0 && m.crease_deg() <= 180.0), f + ".crease_deg",
          "is {}; 5 to 180, where 180 means that there are no creases", m.crease_deg());
  not_negative(s, f + ".weld_m", true, m.weld_m());
  s.check(m.weld_m() < m.element_m(), f + ".weld_m", "is {} m, and element_m is {} m; weld less than an element",
          m.weld_m(), m.element_m());
  s.check(m.up() == proto::SurfaceMesh::Z || m.up() == proto::SurfaceMesh::Y, f + ".up", "is {}; Z or Y",
          static_cast<int>(m.up()));
  const std::string suffix = mesh_suffix(m.path());
  s.check(m.up() == proto::SurfaceMesh::Z || (suffix != ".glb" && suffix != ".gltf"), f + ".up",
          "is Y, and '{}' is turned upright anyway, as glTF says what is up; leave it out", m.path());
  pose(s, f + ".pose", m.pose());
}

void mesh_part(const LoadedScene& s, const std::string& f, const proto::MeshPart& part) {
  s.check(part.group().empty() != part.usemtl().empty(), f, "{}; name one of them",
          part.group().empty() ? "names neither a group nor a usemtl of the file"
                               : "names a group and a usemtl of the file");
  s.check(!part.material().empty() || part.has_thickness_m(), f,
          "has neither a material nor a thickness_m of its own; give one, or leave the part out");
  if (part.has_thickness_m()) positive(s, f + ".thickness_m", true, part.thickness_m(), "m");
  if (part.material().empty()) return;
  const auto& materials = s.message.materials();
  const auto own = std::find_if(materials.begin(), materials.end(),
                                [&](const proto::Material& m) { return m.name() == part.material(); });
  if (own == materials.end()) refuse_name(s, f + ".material", part.material(), "material", names_in(materials));
  s.check(own->has_youngs_modulus() && own->has_poisson_ratio(), f + ".material",
          "'{}' has no youngs_modulus or poisson_ratio; a shell needs both", part.material());
}

void strength_paint(const LoadedScene& s, const std::string& f, const proto::Shell& shell) {
  const proto::StrengthPaint& paint = shell.mesh().strength_paint();
  s.check(paint.channel() >= proto::StrengthPaint::RED && paint.channel() <= proto::StrengthPaint::GREY, f + ".channel",
          "is missing; RED, GREEN, BLUE or GREY");
  strength_factor(s, f + ".low_factor", paint.has_low_factor(), paint.low_factor());
  if (paint.has_high_factor()) strength_factor(s, f + ".high_factor", true, paint.high_factor());
  s.check(any_material_of(s.message, shell, [](const proto::Material& m) { return m.has_strength(); }), f,
          "scales the strength, which material '{}' has not; give it one, or leave this out", shell.material());
}

}  // namespace

void validate_mesh(const LoadedScene& s, const std::string& f, const proto::Shell& shell) {
  const std::string field = f + ".mesh";
  const proto::SurfaceMesh& mesh = shell.mesh();
  surface_mesh(s, field, mesh);
  for (int k = 0; k < mesh.parts_size(); ++k) {
    const std::string own = fmt::format("{}.parts[{}]", field, k);
    mesh_part(s, own, mesh.parts(k));
    for (int i = 0; i < k; ++i)
      s.check(mesh.parts(i).group() != mesh.parts(k).group() || mesh.parts(i).usemtl() != mesh.parts(k).usemtl(), own,
              "is for the same faces as parts[{}]; leave one of them out", i);
  }
  s.check(mesh.parts_size() == 0 || !shell.has_interlayer(), field + ".parts",
          "cannot go with an interlayer, which is for one thickness; leave one of them out");
  if (mesh.has_strength_paint()) strength_paint(s, field + ".strength_paint", shell);
}

}  // namespace sunder::scene
