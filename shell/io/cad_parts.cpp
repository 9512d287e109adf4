#include "shell/io/cad_parts.h"

#include <algorithm>

namespace sunder::shell {
namespace {

constexpr double kShortEdge = 0.5;  // of an element: no seam is that short

// Whether a shell of the scene is several shells of the run.
bool is_several(const std::vector<ScenePart>& parts, int shell) {
  return std::any_of(parts.begin(), parts.end(), [&](const ScenePart& p) {
    return p.shell == shell && p.message.cad().has_face() && p.message.name().find('.') != std::string::npos;
  });
}

// Names of single faces are known only now.
void check_names(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts) {
  const proto::Scene& m = scene.message;
  const auto check = [&](const std::string& field, const std::string& name) {
    if (name.find('.') == std::string::npos) return;
    const std::string whole = name.substr(0, name.find('.'));
    int faces = 0;
    for (const ScenePart& p : parts) {
      if (p.message.name() == name) return;
      faces += p.message.name().rfind(whole + ".", 0) == 0;
    }
    scene.fail(field, fmt::format("is '{}', but shell '{}' has {} faces, counted from 1", name, whole, faces));
  };
  for (int i = 0; i < m.seams().rules_size(); ++i) {
    check(fmt::format("seams.rules[{}].first", i), m.seams().rules(i).first());
    check(fmt::format("seams.rules[{}].second", i), m.seams().rules(i).second());
  }
  for (int i = 0; i < m.output().probes_size(); ++i)
    check(fmt::format("output.probes[{}].shell", i), m.output().probes(i).shell());
}

}  // namespace

std::vector<ScenePart> scene_parts(const scene::LoadedScene& scene, CadFiles& files) {
  std::vector<ScenePart> out;
  for (int i = 0; i < scene.message.shells_size(); ++i) {
    const proto::Shell& shell = scene.message.shells(i);
    const auto& cad = shell.cad();
    const std::string field = fmt::format("shells[{}].cad", i);
    std::vector<int> faces(cad.faces().begin(), cad.faces().end());
    if (shell.has_cad() && !cad.has_face()) {
      const int count = files.of(scene, field, cad.path()).faces();
      for (int k = 0; k < cad.faces_size(); ++k)
        scene.check(cad.faces(k) < count, fmt::format("{}.faces[{}]", field, k),
                    "is {}, but '{}' has {} faces, counted from 0", cad.faces(k), cad.path(), count);
      for (int k = 0; k < count && count > 1 && cad.faces_size() == 0; ++k) faces.push_back(k);
    }
    if (faces.empty()) {
      out.push_back({i, shell});
      continue;
    }
    for (std::size_t k = 0; k < faces.size(); ++k) {
      ScenePart part{i, shell};
      part.message.set_name(fmt::format("{}.{}", shell.name(), k + 1));
      part.message.mutable_cad()->clear_faces();
      part.message.mutable_cad()->set_face(faces[k]);
      out.push_back(std::move(part));
    }
  }
  check_names(scene, out);
  return out;
}

void check_joined(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, CadFiles& files,
                  const RunSetup& setup) {
  for (int i = 0; i < scene.message.shells_size(); ++i) {
    const auto& cad = scene.message.shells(i).cad();
    if (!is_several(parts, i) || cad.fill_holes_m() > 0.0) continue;
    const std::string field = fmt::format("shells[{}].cad", i);
    const double scale = cad.has_scale() ? cad.scale() : 1.0;
    const auto part_of = [&](int face) {
      for (std::size_t k = 0; k < parts.size(); ++k)
        if (parts[k].shell == i && parts[k].message.cad().face() == face) return static_cast<int>(k);
      return -1;
    };
    for (const CadEdge& edge : files.of(scene, field, cad.path()).edges()) {
      if (edge.faces.size() != 2) continue;
      const int a = part_of(edge.faces[0]), b = part_of(edge.faces[1]);
      if (a < 0 || b < 0) continue;
      const ShellModel &first = setup.shells[a].model, &second = setup.shells[b].model;
      const auto open = [&](const proto::SeamRule& rule) {
        return rule.kind() == proto::SeamRule::OPEN &&
               std::minmax(rule.first(), rule.second()) == std::minmax(first.name, second.name);
      };
      const auto joins = [&](const Seam& s) { return std::minmax(s.first, s.second) == std::minmax(a, b); };
      const auto& rules = scene.message.seams().rules();
      const auto& seams = setup.stitches.seams;
      scene.check(
          std::any_of(seams.begin(), seams.end(), joins) || std::any_of(rules.begin(), rules.end(), open) ||
              edge.length * scale < kShortEdge * std::max(first.spacing, second.spacing),
          field + ".path",
          "'{}': faces {} and {} share an edge of {:.3g} m about ({:.4g}, {:.4g}, {:.4g}) m, but '{}' and '{}' do "
          "not meet there; give a larger seams.tolerance_m, or add to seams: rules {{ first: \"{}\" second: "
          "\"{}\" kind: OPEN }}",
          cad.path(), edge.faces[0], edge.faces[1], edge.length * scale, scale * edge.middle.x(),
          scale * edge.middle.y(), scale * edge.middle.z(), first.name, second.name, first.name, second.name);
    }
  }
}

}  // namespace sunder::shell
