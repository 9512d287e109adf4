#include "shell/io/part_names.h"

namespace sunder::shell {
namespace {

// "is 5 shells, part.1 to part.5", or "is one shell".
std::string count_of(const std::vector<ScenePart>& parts, const std::vector<int>& own) {
  return own.size() == 1 ? "is one shell"
                         : fmt::format("is {} shells, {} to {}", own.size(), parts[own.front()].message.name(),
                                       parts[own.back()].message.name());
}

}  // namespace

std::vector<int> shells_named(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts,
                              const std::string& field, const std::string& name) {
  const std::string whole = name.substr(0, name.find('.'));
  std::vector<int> own;
  for (int k = 0; k < static_cast<int>(parts.size()); ++k) {
    if (parts[k].message.name() == name) return {k};
    if (scene.message.shells(parts[k].shell).name() == whole) own.push_back(k);
  }
  if (whole != name && !own.empty())
    scene.fail(field, fmt::format("is '{}', but '{}' {}; name {}", name, whole, count_of(parts, own),
                                  own.size() == 1 ? parts[own[0]].message.name() : "one of them"));
  return own;
}

int shell_named(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, const std::string& field,
                const std::string& name) {
  const std::vector<int> found = shells_named(scene, parts, field, name);
  scene.check(!found.empty(), field, "'{}' is no shell of this scene", name);
  scene.check(found.size() == 1, field, "'{}' {}; name one", name, count_of(parts, found));
  return found[0];
}

void check_names(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts) {
  const proto::Scene& m = scene.message;
  for (int i = 0; i < m.seams().rules_size(); ++i) {
    shell_named(scene, parts, fmt::format("seams.rules[{}].first", i), m.seams().rules(i).first());
    shell_named(scene, parts, fmt::format("seams.rules[{}].second", i), m.seams().rules(i).second());
  }
  for (int i = 0; i < m.output().probes_size(); ++i) {
    const auto& p = m.output().probes(i);
    if (p.body().empty()) shell_named(scene, parts, fmt::format("output.probes[{}].shell", i), p.shell());
    if (!p.other_shell().empty())
      shell_named(scene, parts, fmt::format("output.probes[{}].other_shell", i), p.other_shell());
  }
  for (int i = 0; i < m.strength_lines_size(); ++i)
    for (int k = 0; k < m.strength_lines(i).shells_size(); ++k)
      shells_named(scene, parts, fmt::format("strength_lines[{}].shells[{}]", i, k), m.strength_lines(i).shells(k));
  for (int i = 0; i < m.bodies_size(); ++i)
    shells_named(scene, parts, fmt::format("bodies[{}].launch.target", i), m.bodies(i).launch().target());
}

}  // namespace sunder::shell
