// Checks where the thickness of a shell varies: law, map and paint.
#include "coupler/scene/checks.h"

namespace sunder::scene {
namespace {

void thickness_law(const LoadedScene& s, const std::string& f, const proto::ThicknessLaw& law) {
  s.check(law.along() >= proto::ThicknessLaw::U && law.along() <= proto::ThicknessLaw::Z, f + ".along",
          "is missing; U, V, X, Y or Z");
  s.check(law.points_size() >= 2, f + ".points", "has {} of them; give two or more, {{ at_m factor }}",
          law.points_size());
  for (int i = 0; i < law.points_size(); ++i) {
    const std::string own = fmt::format("{}.points[{}]", f, i);
    const double at = law.points(i).at_m();
    s.check(std::isfinite(at), own + ".at_m", "is {}; must be finite", at);
    s.check(i == 0 || at > law.points(i - 1).at_m(), own + ".at_m",
            "is {} m, and the point before it is at {} m; coordinates rise from point to point", at,
            i == 0 ? 0.0 : law.points(i - 1).at_m());
    thickness_factor(s, own + ".factor", law.points(i).has_factor(), law.points(i).factor());
  }
}

}  // namespace

void validate_thickness(const LoadedScene& s, const std::string& f, const proto::Shell& shell) {
  const bool law = shell.has_thickness_law(), map = shell.has_thickness_map(),
             paint = shell.has_mesh() && shell.mesh().has_thickness_paint();
  if (!law && !map && !paint) return;
  const std::string own = f + (law ? ".thickness_law" : map ? ".thickness_map" : ".mesh.thickness_paint");
  s.check(!shell.has_interlayer(), own,
          "cannot go with an interlayer: plies and film would each need a law of their own; leave one of them out");
  s.check(!shell.has_fibres(), own, "cannot go with fibres, which are as long as one thickness; leave one of them out");
  if (law) thickness_law(s, f + ".thickness_law", shell.thickness_law());
  // points of a file are moved before they have parameters
  const bool moved = shell.has_mesh() && shell.reference() != proto::Shell::MIDDLE;
  s.check(!moved || !law || shell.thickness_law().along() >= proto::ThicknessLaw::X, f + ".thickness_law.along",
          "is {}, and reference moves the points of a mesh before they have parameters; take X, Y or Z, or leave "
          "reference out",
          proto::ThicknessLaw::Along_Name(shell.thickness_law().along()));
  s.check(!moved || !map, f + ".thickness_map",
          "is given, and reference moves the points of a mesh before they have parameters; give thickness_paint or a "
          "thickness_law along X, Y or Z, or leave reference out");
  if (map) {
    const proto::ThicknessMap& m = shell.thickness_map();
    const std::string field = f + ".thickness_map";
    s.check(!m.path().empty(), field + ".path", "is missing; name a PNG or PGM file beside the scene");
    thickness_factor(s, field + ".low_factor", m.has_low_factor(), m.low_factor());
    if (m.has_high_factor()) thickness_factor(s, field + ".high_factor", true, m.high_factor());
  }
  if (!paint) return;
  const proto::ThicknessPaint& p = shell.mesh().thickness_paint();
  const std::string field = f + ".mesh.thickness_paint";
  s.check(p.channel() >= proto::StrengthPaint::RED && p.channel() <= proto::StrengthPaint::GREY, field + ".channel",
          "is missing; RED, GREEN, BLUE or GREY");
  thickness_factor(s, field + ".low_factor", p.has_low_factor(), p.low_factor());
  if (p.has_high_factor()) thickness_factor(s, field + ".high_factor", true, p.high_factor());
}

}  // namespace sunder::scene
