// Checks the mass that a scene lets small elements have.
#include <cmath>

#include "coupler/scene/checks.h"
#include "coupler/scene/names.h"

namespace sunder::scene {
namespace {

constexpr int kMostComparedModes = 100;

}  // namespace

void validate_mass_scaling(const LoadedScene& s) {
  if (!s.message.has_mass_scaling()) return;
  const proto::MassScaling& m = s.message.mass_scaling();
  const std::string f = "mass_scaling";
  s.check(!is_static(s.message), f, "lengthens substeps, and in this scene nothing moves; leave it out");
  s.check(s.message.shells_size() > 0, f, "is for shells, and the scene has none; leave it out");
  s.check(m.has_step_s() || m.has_factor(), f,
          "says neither step_s nor factor; give one of them, for example factor: 1.5");
  s.check(!m.has_step_s() || !m.has_factor(), f + ".step_s", "and factor are both given; leave one of them out");
  if (m.has_step_s()) positive(s, f + ".step_s", true, m.step_s(), "s");
  s.check(!m.has_factor() || (std::isfinite(m.factor()) && m.factor() > 1.0), f + ".factor",
          "is {}; give more than 1, or leave mass_scaling out", m.factor());
  s.check(!m.has_most_added() || (m.most_added() > 0.0 && m.most_added() <= 1.0), f + ".most_added",
          "is {}; a share of the mass, above 0 and at most 1", m.most_added());
  s.check(!m.has_most_error() || (m.most_error() > 0.0 && m.most_error() < 1.0), f + ".most_error",
          "is {}; a share of a frequency, above 0 and below 1", m.most_error());
  s.check(!m.has_modes() || (m.modes() >= 1 && m.modes() <= kMostComparedModes), f + ".modes", "is {}; 1 to {}",
          m.modes(), kMostComparedModes);
  s.check(s.message.transfer().kind() == proto::GridTransfer::DIRECT, f,
          "is for forces that act on control points, and transfer sends velocities through a grid; leave one of them "
          "out");
  for (int i = 0; i < m.shells_size(); ++i) {
    const std::string field = fmt::format("{}.shells[{}]", f, i);
    for (int k = 0; k < i; ++k)
      s.check(m.shells(k) != m.shells(i), field, "names '{}' again; leave it out", m.shells(i));
    if (is_shell(s.message, m.shells(i))) continue;
    std::vector<std::string> names;
    for (const proto::Shell& shell : s.message.shells()) names.push_back(shell.name());
    refuse_name(s, field, m.shells(i), "shell", names);
  }
  for (int i = 0; i < s.message.shells_size(); ++i)
    s.check(!s.message.shells(i).has_fibres(), fmt::format("shells[{}].fibres", i),
            "exclude mass_scaling; leave one of them out");
}

}  // namespace sunder::scene
