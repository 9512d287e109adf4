#include "shell/io/cad_parts.h"

#include <algorithm>
#include <set>

#include "shell/io/cad_sides.h"
#include "shell/io/mesh_parts.h"
#include "shell/io/part_names.h"
#include "shell/io/ring_sectors.h"

namespace sunder::shell {
namespace {

constexpr double kTolerances = 2.0;  // of an edge or an approximation: both faces have one
constexpr double kShortEdge = 0.5;   // of an element: no seam is that short

// Whether a shell of the scene is several shells of the run.
bool is_several(const std::vector<ScenePart>& parts, int shell) {
  return std::any_of(parts.begin(), parts.end(), [&](const ScenePart& p) {
    return p.shell == shell && p.message.cad().has_face() && p.message.name().find('.') != std::string::npos;
  });
}

// A shell for each chart of a mesh.
void add_charts(const scene::LoadedScene& scene, int shell, CadFiles& files, std::vector<ScenePart>& out) {
  const proto::Shell& m = scene.message.shells(shell);
  const std::string field = fmt::format("shells[{}]", shell);
  const MeshShells& mesh = files.mesh(scene, field + ".mesh", m);
  const int charts = static_cast<int>(mesh.surfaces.size());
  check_one_patch(scene, m, field, charts);
  for (int k = 0; k < charts; ++k) {
    ScenePart& part = out.emplace_back(ScenePart{shell, shell_of_chart(m, mesh, k), k, 0.0});
    if (charts > 1) part.message.set_name(fmt::format("{}.{}", m.name(), k + 1));
  }
}

// Those of the faces of an edge that a shell takes; twice the same where a face meets itself.
std::vector<int> taken_of(const CadEdge& edge, const std::vector<int>& faces) {
  std::vector<int> out;
  for (const int face : edge.faces)
    if (std::find(faces.begin(), faces.end(), face) != faces.end()) out.push_back(face);
  return out;
}

// Throws Error where more than two of the faces of a shell share an edge.
void check_edges(const scene::LoadedScene& scene, const std::string& field, const proto::CadFace& cad,
                 const std::vector<CadEdge>& edges, const std::vector<int>& faces) {
  const double scale = cad.has_scale() ? cad.scale() : 1.0;
  for (const CadEdge& edge : edges) {
    std::vector<int> own = taken_of(edge, faces);
    std::sort(own.begin(), own.end());
    scene.check(own.size() <= 2, field + ".path",
                "'{}': faces {} share an edge of {:.3g} m about ({:.4g}, {:.4g}, {:.4g}) m, where a shell joins two "
                "faces at most; leave faces out until two are left there, such as faces: [{}, {}], or divide the part "
                "in the CAD program",
                cad.path(), fmt::join(own, ", "), edge.length * scale, scale * edge.middle.x(), scale * edge.middle.y(),
                scale * edge.middle.z(), own.size() > 2 ? own[0] : 0, own.size() > 2 ? own[1] : 0);
  }
}

// Faces of the file that a shell of the scene takes.
std::vector<int> faces_of(const std::vector<ScenePart>& parts, int shell) {
  std::vector<int> out;
  for (const ScenePart& part : parts)
    if (part.shell == shell) out.push_back(part.message.cad().face());
  return out;
}

}  // namespace

std::vector<ScenePart> scene_parts(const scene::LoadedScene& scene, CadFiles& files) {
  std::vector<ScenePart> out;
  for (int i = 0; i < scene.message.shells_size(); ++i) {
    const proto::Shell& shell = scene.message.shells(i);
    const auto& cad = shell.cad();
    const std::string field = fmt::format("shells[{}].cad", i);
    if (shell.has_mesh()) {
      add_charts(scene, i, files, out);
      continue;
    }
    if (scene::has_sectors(shell)) {
      for (int k = 0; k < ring_sectors(shell); ++k) out.push_back({i, shell_of_sector(shell, k), k, 0.0});
      continue;
    }
    if (!shell.has_cad()) {
      out.push_back({i, shell, 0, 0.0});
      continue;
    }
    const CadFile& file = files.of(scene, field, cad);
    const std::vector<int> faces = file.chosen(scene, field, cad);
    scene.check(static_cast<int>(faces.size()) <= kMostFaces, field + (cad.faces_size() > 0 ? ".faces" : ".path"),
                "'{}': {} faces would be as many shells, and at most {} are taken; choose by `faces: [0, 1, 2]`, which "
                "`sunder inspect` numbers, or unite faces in the CAD program",
                cad.path(), faces.size(), kMostFaces);
    const std::vector<CadEdge> edges = file.edges();
    check_edges(scene, field, cad, edges, faces);
    const std::vector<int> turned = faces.size() > 1 ? faces_to_turn(edges, faces) : std::vector<int>();
    std::vector<ScenePart> own;
    for (const int face : faces) {
      ScenePart part{i, shell, 0, 0.0};
      part.message.mutable_cad()->clear_faces();
      part.message.mutable_cad()->set_face(face);
      if (std::binary_search(turned.begin(), turned.end(), face)) part.message.mutable_cad()->add_faces(face);
      const std::vector<CadSurface> surfaces = file.surfaces(scene, field, part.message.cad());
      const auto count = static_cast<int>(surfaces.size());
      for (const CadSurface& s : surfaces) part.apart = std::max(part.apart, kTolerances * s.error);
      for (const CadEdge& e : edges)
        if (std::find(e.faces.begin(), e.faces.end(), face) != e.faces.end())
          part.apart = std::max(part.apart, kTolerances * e.tolerance * (cad.has_scale() ? cad.scale() : 1.0));
      for (part.part = 0; part.part < count; ++part.part) own.push_back(part);
    }
    if (own.size() > 1 || cad.faces_size() > 0)
      for (std::size_t k = 0; k < own.size(); ++k) own[k].message.set_name(fmt::format("{}.{}", shell.name(), k + 1));
    std::move(own.begin(), own.end(), std::back_inserter(out));
  }
  check_names(scene, out);
  return out;
}

std::vector<std::vector<char>> may_meet(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts,
                                        CadFiles& files) {
  std::vector<std::vector<char>> out(parts.size(), std::vector<char>(parts.size(), 1));
  for (int i = 0; i < scene.message.shells_size(); ++i) {
    if (scene.message.shells(i).has_mesh()) {
      const MeshShells& mesh = files.mesh(scene, fmt::format("shells[{}].mesh", i), scene.message.shells(i));
      std::set<std::pair<int, int>> beside;
      for (const MeshSeam& s : mesh.charts.seams) beside.insert(std::minmax(s.first, s.second));
      for (std::size_t a = 0; a < parts.size(); ++a)
        for (std::size_t b = 0; b < parts.size(); ++b)
          if (parts[a].shell == i && parts[b].shell == i)
            out[a][b] = beside.count(std::minmax(parts[a].part, parts[b].part)) != 0;
    }
    if (const proto::Shell& ring = scene.message.shells(i); scene::has_sectors(ring)) {
      for (std::size_t a = 0; a < parts.size(); ++a)
        for (std::size_t b = 0; b < parts.size(); ++b) {
          const int apart = std::abs(parts[a].part - parts[b].part), last = ring_sectors(ring) - 1;
          if (parts[a].shell == i && parts[b].shell == i)
            out[a][b] = apart == 1 || (apart == last && scene::is_closed(ring));
        }
    }
    if (!is_several(parts, i)) continue;
    const auto edges = files.of(scene, fmt::format("shells[{}].cad", i), scene.message.shells(i).cad()).edges();
    const std::vector<int> faces = faces_of(parts, i);
    std::set<std::pair<int, int>> beside;
    std::set<int> free;
    for (const CadEdge& e : edges) {
      const std::vector<int> own = taken_of(e, faces);
      if (own.size() == 1) free.insert(own[0]);
      for (const int a : e.faces)
        for (const int b : e.faces) beside.insert({a, b});
    }
    for (std::size_t a = 0; a < parts.size(); ++a)
      for (std::size_t b = 0; b < parts.size(); ++b) {
        if (parts[a].shell != i || parts[b].shell != i) continue;
        const int one = parts[a].message.cad().face(), other = parts[b].message.cad().face();
        out[a][b] = one == other || beside.count({one, other}) || (free.count(one) && free.count(other));
      }
  }
  return out;
}

void check_joined(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, CadFiles& files,
                  const RunSetup& setup) {
  for (int i = 0; i < scene.message.shells_size(); ++i) {
    const auto& cad = scene.message.shells(i).cad();
    if (!is_several(parts, i) || cad.fill_holes_m() > 0.0) continue;
    const std::string field = fmt::format("shells[{}].cad", i);
    const double scale = cad.has_scale() ? cad.scale() : 1.0;
    const auto parts_of = [&](int face) {
      std::vector<int> found;
      for (std::size_t k = 0; k < parts.size(); ++k)
        if (parts[k].shell == i && parts[k].message.cad().face() == face) found.push_back(static_cast<int>(k));
      return found;
    };
    const std::vector<int> faces = faces_of(parts, i);
    for (const CadEdge& edge : files.of(scene, field, cad).edges()) {
      const std::vector<int> own = taken_of(edge, faces);
      if (own.size() != 2) continue;
      const std::vector<int> first = parts_of(own[0]), second = parts_of(own[1]);
      double spacing = 0.0;
      bool joined = false;
      for (const int a : first)
        for (const int b : second) {
          const ShellModel &one = setup.shells[a].model, &other = setup.shells[b].model;
          spacing = std::max({spacing, one.spacing, other.spacing});
          for (const Seam& s : setup.stitches.seams)
            joined = joined || std::minmax(s.first, s.second) == std::minmax(a, b);
          for (const proto::SeamRule& rule : scene.message.seams().rules())
            joined = joined || (rule.kind() == proto::SeamRule::OPEN &&
                                std::minmax(rule.first(), rule.second()) == std::minmax(one.name, other.name));
        }
      const std::string &one = setup.shells[first[0]].model.name, &other = setup.shells[second[0]].model.name;
      scene.check(
          joined || edge.length * scale < kShortEdge * spacing, field + ".path",
          "'{}': faces {} and {} share an edge of {:.3g} m about ({:.4g}, {:.4g}, {:.4g}) m, but '{}' and '{}' do "
          "not meet there; {}give a larger seams.tolerance_m, or add to seams: rules {{ first: \"{}\" second: "
          "\"{}\" kind: OPEN }}",
          cad.path(), own[0], own[1], edge.length * scale, scale * edge.middle.x(), scale * edge.middle.y(),
          scale * edge.middle.z(), one, other,
          scene.message.shells(i).reference() == proto::Shell::MIDDLE
              ? ""
              : "faces that meet in a crease have no common middle surface: leave reference out, or ",
          one, other);
    }
  }
}

}  // namespace sunder::shell
