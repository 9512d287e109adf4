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

// Fields of frames, or of a point where `of_point`.
template <class Fields>
void fields(const LoadedScene& s, const std::string& f, const Fields& given, bool of_point) {
  using proto::Output;
  const proto::Scene& m = s.message;
  const auto any_material = [&](auto&& has) {
    return std::any_of(m.shells().begin(), m.shells().end(),
                       [&](const proto::Shell& shell) { return any_material_of(m, shell, has); });
  };
  std::set<int> seen;
  for (int i = 0; i < given.size(); ++i) {
    const int field = given[i];
    const std::string g = fmt::format("{}[{}]", f, i);
    s.check(field > Output::FIELD_UNSPECIFIED && Output::Field_IsValid(field), g,
            "is {}; name STRESS, STRAIN, MEMBRANE_FORCE, BENDING_MOMENT, PLASTIC_STRAIN, THICKNESS, CONTACT_PRESSURE "
            "or BODY_MOTION",
            field);
    const std::string name = Output::Field_Name(static_cast<Output::Field>(field));
    s.check(seen.insert(field).second, g, "names {} twice", name);
    s.check(field != Output::BODY_MOTION || !of_point, g,
            "is BODY_MOTION, and this is a point of a shell; probe the body instead");
    s.check(field == Output::BODY_MOTION || m.shells_size() > 0, g, "is {}, and the scene has no shell; leave it out",
            name);
    s.check(field != Output::PLASTIC_STRAIN ||
                any_material([](const proto::Material& material) { return material.has_yield_stress(); }),
            g, "is PLASTIC_STRAIN, and no shell's material has a yield_stress; leave it out");
    s.check(field != Output::BODY_MOTION || m.bodies_size() > 0 ||
                any_material([](const proto::Material& material) { return material.has_strength(); }),
            g, "is BODY_MOTION, and the scene has no rigid body and no shell that breaks; leave it out");
  }
}

// The second shell of a probe.
void other_shell(const LoadedScene& s, const std::string& f, const proto::Probe& p) {
  const proto::Scene& m = s.message;
  const std::string g = f + ".other_shell";
  s.check(p.body().empty(), g, "is a second shell, and a body is given; leave one of them out");
  s.check(!p.shell().empty(), g, "is a second shell, and shell is missing; name the first one");
  s.check(!p.has_at() && p.fields_size() == 0, g,
          "makes this the contact of two shells, and at or fields are those of a point; leave them out");
  s.check(p.shell() != p.other_shell(), g, "is '{}', as shell is; name another one", p.other_shell());
  s.check(!is_static(m), g,
          "makes this the contact of two shells, and in this scene nothing moves; leave the probe out");
  const std::vector<std::string> shells = names_in(m.shells());
  if (!is_shell(m, p.other_shell())) refuse_name(s, g, p.other_shell(), "shell", shells);
  const auto has_fibres = [&](const std::string& name) {
    const std::string whole = name.substr(0, name.find('.'));
    return std::any_of(m.shells().begin(), m.shells().end(), [&](const proto::Shell& shell) {
      return (shell.name() == name || shell.name() == whole) && shell.has_fibres();
    });
  };
  s.check(!has_fibres(p.shell()) || !has_fibres(p.other_shell()), g,
          "is '{}', and both shells have fibres, whose forces are not measured; leave the probe out", p.other_shell());
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
  fields(s, "output.fields", o.fields(), false);
  s.check(!o.thick_shells() || m.shells_size() > 0, "output.thick_shells",
          "is true, and the scene has no shell; leave it out");
  std::set<std::string> probes;
  for (int i = 0; i < o.probes_size(); ++i) {
    const auto& p = o.probes(i);
    const std::string f = fmt::format("output.probes[{}]", i);
    unique_name(s, f, p.name(), probes);
    if (!p.body().empty()) {
      std::vector<std::string> bodies = names_in(m.bodies());
      for (const std::string& soft : names_in(m.soft_bodies())) bodies.push_back(soft);
      if (!is_in(p.body(), bodies)) refuse_name(s, f + ".body", p.body(), "body", bodies);
      s.check(!p.has_at(), f + ".at", "is a point of a shell, and a body is given; leave one of them out");
      s.check(p.fields_size() == 0, f + ".fields",
              "are those of a point of a shell, and a body is given; leave one out");
      if (p.shell().empty()) continue;
      const std::vector<std::string> rigid = names_in(m.bodies());
      s.check(is_in(p.body(), rigid), f + ".body",
              "is '{}', a soft body, whose contact with a shell is not measured; name a rigid body, or leave shell out",
              p.body());
    }
    const std::vector<std::string> shells = names_in(m.shells());
    if (!p.other_shell().empty()) other_shell(s, f, p);
    if (!is_shell(m, p.shell())) refuse_name(s, f + ".shell", p.shell(), "shell", shells, "name a shell, or a body");
    fields(s, f + ".fields", p.fields(), true);
  }
}

}  // namespace sunder::scene
