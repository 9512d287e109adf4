// Checks intervals of output, and probes.
#include <algorithm>
#include <set>

#include "coupler/scene/checks.h"
#include "coupler/scene/names.h"

namespace sunder::scene {
namespace {

bool is_in(const std::string& name, const std::vector<std::string>& names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

void validate_output(const LoadedScene& s) {
  const proto::Scene& m = s.message;
  const auto& o = m.output();
  if (o.has_frame_interval_s()) positive(s, "output.frame_interval_s", true, o.frame_interval_s(), "s");
  if (o.has_shell_frame_interval_s())
    positive(s, "output.shell_frame_interval_s", true, o.shell_frame_interval_s(), "s");
  if (o.has_probe_interval_s()) positive(s, "output.probe_interval_s", true, o.probe_interval_s(), "s");
  not_negative(s, "output.checkpoint_interval_s", o.has_checkpoint_interval_s(), o.checkpoint_interval_s());
  std::set<std::string> probes;
  for (int i = 0; i < o.probes_size(); ++i) {
    const auto& p = o.probes(i);
    const std::string f = fmt::format("output.probes[{}]", i);
    unique_name(s, f, p.name(), probes);
    if (!p.body().empty()) {
      std::vector<std::string> bodies = names_in(m.bodies());
      for (const std::string& soft : names_in(m.soft_bodies())) bodies.push_back(soft);
      if (!is_in(p.body(), bodies)) refuse_name(s, f + ".body", p.body(), "body", bodies);
      s.check(p.shell().empty() && !p.has_at(), f + ".body",
              "is given, and so is a point of a shell; give one of them");
      continue;
    }
    const std::vector<std::string> shells = names_in(m.shells());
    if (!is_shell(m, p.shell())) refuse_name(s, f + ".shell", p.shell(), "shell", shells, "name a shell, or a body");
  }
}

}  // namespace sunder::scene
