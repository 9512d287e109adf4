// Checks rings, and edges that only rings have.
#include "coupler/scene/checks.h"

namespace sunder::scene {
namespace {

constexpr double kMostAcross = 4096.0;  // elements

// The edges of a support or load.
void ring_edge(const LoadedScene& s, const std::string& f, const proto::Shell& shell, int edge) {
  const bool rim = edge == proto::Support::INNER || edge == proto::Support::OUTER;
  s.check(!rim || shell.has_annulus(), f, "has {}, a rim of an annulus; name ALL, U_MIN, U_MAX, V_MIN or V_MAX",
          edge == proto::Support::INNER ? "INNER" : "OUTER");
  s.check(!is_closed(shell) || (edge != proto::Support::U_MIN && edge != proto::Support::U_MAX), f,
          "has {}, where the ring is closed; name {}", edge == proto::Support::U_MIN ? "U_MIN" : "U_MAX",
          shell.has_annulus() ? "INNER or OUTER, or cut it through with `slit: true`" : "V_MIN or V_MAX");
}

// What a shell of several sectors has to be without.
void of_several(const LoadedScene& s, const std::string& f, const proto::Shell& shell) {
  constexpr double kOneSector = 90.0;  // [degrees]
  const char* const what = shell.has_annulus() ? "a ring may be several" : "an arc so wide is several";
  const auto refuse = [&](bool given, const std::string& own, const char* remedy) {
    s.check(!given, f + "." + own, "is for a shell of one patch, and {}; {}", what, remedy);
  };
  for (int i = 0; i < shell.supports_size(); ++i)
    refuse(shell.supports(i).corners_size() + shell.supports(i).regions_size() > 0, fmt::format("supports[{}]", i),
           "name edges, or give boxes, which are places in space");
  for (int i = 0; i < shell.cuts_size(); ++i)
    refuse(!shell.cuts(i).has_line(), fmt::format("cuts[{}]", i), "give a line, whose points are places in space");
  for (int i = 0; i < shell.loads_size(); ++i)
    refuse(shell.loads(i).has_point(), fmt::format("loads[{}].point", i), "give edge_force or pressure");
  refuse(shell.trims_size() > 0, "trims", "take a plate with round trims");
  refuse(shell.strength_regions_size() > 0, "strength_regions", "leave them out");
  refuse(shell.has_strength_map(), "strength_map", "leave it out");
  refuse(shell.has_thickness_map(), "thickness_map", "leave it out, or give a thickness_law");
  s.check(shell.thickness_law().along() != proto::ThicknessLaw::U || arc_deg(shell) <= kOneSector,
          f + ".thickness_law.along",
          "is U, which begins anew in each sector of a ring; take X, Y or Z, or give angle_deg {}",
          shell.has_annulus() ? fmt::format("of at most {:.0f}", kOneSector) : fmt::format("below {:.0f}", kWideArc));
  refuse(shell.strength_lines_size() > 0, "strength_lines",
         "leave them out, or give strength_lines of the scene, in space");
}

}  // namespace

void validate_annulus(const LoadedScene& s, const std::string& f, const proto::Shell& shell) {
  for (int i = 0; i < shell.supports_size(); ++i)
    for (const int edge : shell.supports(i).edges())
      ring_edge(s, fmt::format("{}.supports[{}].edges", f, i), shell, edge);
  for (int i = 0; i < shell.loads_size(); ++i) {
    const std::string field = fmt::format("{}.loads[{}]", f, i);
    if (shell.loads(i).has_edge_force())
      ring_edge(s, field + ".edge_force.edge", shell, shell.loads(i).edge_force().edge());
    if (shell.loads(i).has_edge_moment())
      ring_edge(s, field + ".edge_moment.edge", shell, shell.loads(i).edge_moment().edge());
  }
  if (!has_sectors(shell)) return;
  of_several(s, f, shell);
  if (shell.has_cone())
    s.check(shell.cone().top_m() > 0.0, f + ".cone.top_m",
            "is 0, and an arc of {} degrees is several patches, which do not meet in a point; give a small radius, or "
            "angle_deg below {:.0f}",
            shell.cone().angle_deg(), kWideArc);
  if (!shell.has_annulus()) return;
  const std::string at = f + ".annulus";
  const auto& m = shell.annulus();
  s.check(!m.has_inner_m() || m.inner_m() != 0.0, at + ".inner_m",
          "is 0, and a ring has a hole; for a whole disc take a plate with a round trim");
  positive(s, at + ".inner_m", m.has_inner_m(), m.inner_m(), "m");
  positive(s, at + ".outer_m", m.has_outer_m(), m.outer_m(), "m");
  s.check(m.outer_m() > m.inner_m(), at + ".outer_m", "is {} m, and inner_m is {} m; give a larger one", m.outer_m(),
          m.inner_m());
  positive(s, at + ".element_m", m.has_element_m(), m.element_m(), "m");
  s.check(!m.has_angle_deg() || (m.angle_deg() > 0.0 && m.angle_deg() <= 360.0), at + ".angle_deg",
          "is {} degrees; above 0, at most 360", m.angle_deg());
  s.check(!m.slit() || !m.has_angle_deg() || m.angle_deg() == 360.0, at + ".slit",
          "cuts a whole ring through, and angle_deg is {}; leave one of them out", m.angle_deg());
  s.check(2.0 * 3.1415926 * m.outer_m() <= kMostAcross * m.element_m(), at + ".element_m",
          "is {} m, more than {:.0f} elements along the outer rim; give a longer one", m.element_m(), kMostAcross);
  pose(s, at + ".pose", m.pose());
}

double arc_deg(const proto::Shell& shell) {
  if (shell.has_annulus()) return shell.annulus().has_angle_deg() ? shell.annulus().angle_deg() : 360.0;
  return shell.has_cylinder() ? shell.cylinder().angle_deg() : shell.has_cone() ? shell.cone().angle_deg() : 0.0;
}

bool has_sectors(const proto::Shell& shell) { return shell.has_annulus() || arc_deg(shell) >= kWideArc; }

bool is_closed(const proto::Shell& shell) {
  return has_sectors(shell) && arc_deg(shell) == 360.0 && !(shell.has_annulus() && shell.annulus().slit());
}

}  // namespace sunder::scene
