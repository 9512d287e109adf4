// Checks where shells are weaker or stronger than their material: regions, maps and lines.
#include <algorithm>

#include "coupler/scene/checks.h"
#include "coupler/scene/names.h"

namespace sunder::scene {
namespace {

using Scene = LoadedScene;

void strength_region(const Scene& s, const std::string& f, const proto::StrengthRegion& r) {
  strength_factor(s, f + ".factor", r.has_factor(), r.factor());
  if (r.has_disc()) {
    s.check(!r.has_low() && !r.has_high(), f + ".disc", "is given, and so is a box; give one of them");
    s.check(r.disc().has_center(), f + ".disc.center", "is missing; give u and v");
    finite(s, f + ".disc.center", r.disc().center());
    positive(s, f + ".disc.radius_m", r.disc().has_radius_m(), r.disc().radius_m(), "m");
    return;
  }
  s.check(r.has_low() && r.has_high(), f, "has no place; give low and high {{ u v }}, or disc {{ center radius_m }}");
  finite(s, f + ".low", r.low()), finite(s, f + ".high", r.high());
  s.check(r.low().u() <= r.high().u() && r.low().v() <= r.high().v(), f,
          "is a box whose low corner is above its high one");
}

// Points, width and factor of a line in parameters or in space; `at` gives a point as a Vec3.
template <class Line, class At>
void strength_line(const Scene& s, const std::string& f, const Line& line, At&& at) {
  s.check(line.points_size() >= 2, f + ".points", "has {} of them; a line has two or more", line.points_size());
  for (int i = 0; i < line.points_size(); ++i) {
    finite(s, fmt::format("{}.points[{}]", f, i), line.points(i));
    s.check(i == 0 || at(line.points(i)) != at(line.points(i - 1)), fmt::format("{}.points[{}]", f, i),
            "is where the point before it is; leave one of them out");
  }
  positive(s, f + ".width_m", line.has_width_m(), line.width_m(), "m");
  strength_factor(s, f + ".factor", line.has_factor(), line.factor());
}

}  // namespace

void validate_strength(const LoadedScene& s, const std::string& f, const proto::Shell& shell) {
  const bool map_given = shell.has_strength_map(), lines = shell.strength_lines_size() > 0;
  for (const auto& m : s.message.materials())
    s.check(m.name() != shell.material() || m.has_strength() ||
                (shell.strength_regions_size() == 0 && !map_given && !lines),
            f + (map_given ? ".strength_map"
                 : lines   ? ".strength_lines"
                           : ".strength_regions"),
            "scales the strength, which material '{}' has not; give it one, or leave this out", m.name());
  for (int i = 0; i < shell.strength_regions_size(); ++i)
    strength_region(s, fmt::format("{}.strength_regions[{}]", f, i), shell.strength_regions(i));
  for (int i = 0; i < shell.strength_lines_size(); ++i)
    strength_line(s, fmt::format("{}.strength_lines[{}]", f, i), shell.strength_lines(i),
                  [](const proto::ParameterPoint& p) { return Vec3(p.u(), p.v(), 0.0); });
  if (!map_given) return;
  const auto& map = shell.strength_map();
  s.check(!map.path().empty(), f + ".strength_map.path", "is missing; name a PNG or PGM file beside the scene");
  strength_factor(s, f + ".strength_map.low_factor", map.has_low_factor(), map.low_factor());
  if (map.has_high_factor()) strength_factor(s, f + ".strength_map.high_factor", true, map.high_factor());
}

void validate_strength_lines(const LoadedScene& s) {
  const proto::Scene& m = s.message;
  const auto breaks = [&](const proto::Shell& shell) {
    return any_material_of(m, shell, [](const proto::Material& material) { return material.has_strength(); });
  };
  for (int i = 0; i < m.strength_lines_size(); ++i) {
    const proto::SpaceLine& line = m.strength_lines(i);
    const std::string f = fmt::format("strength_lines[{}]", i);
    strength_line(s, f, line, [](const proto::Vec3& p) { return to_vec(p); });
    for (int k = 0; k < line.shells_size(); ++k) {
      const std::string g = fmt::format("{}.shells[{}]", f, k);
      if (!is_shell(m, line.shells(k))) refuse_name(s, g, line.shells(k), "shell", names_in(m.shells()));
      for (const proto::Shell& shell : m.shells())
        s.check(shell.name() != line.shells(k) || breaks(shell), g,
                "is '{}', whose material '{}' has no strength; leave it out, or give the material one", shell.name(),
                shell.material());
    }
    s.check(std::any_of(m.shells().begin(), m.shells().end(), breaks), f,
            "is given, and no shell has a material with a strength; leave it out, or give a strength");
  }
}

}  // namespace sunder::scene
