// Checks joints, seams, and the coupling scheme with its window.
#include <algorithm>
#include <cmath>
#include <set>

#include "coupler/scene/checks.h"
#include "coupler/scene/names.h"

namespace sunder::scene {
namespace {

constexpr int kMostIterations = 100;
constexpr double kMostHalvings = 20.0;

void joint(const LoadedScene& s, const std::string& field, const proto::BodyJoint& j, std::set<std::string>& names) {
  s.check(!j.name().empty() && names.insert(j.name()).second, field + ".name", "'{}' is empty or used twice", j.name());
  s.check(j.kind() != proto::BodyJoint::KIND_UNSPECIFIED && proto::BodyJoint::Kind_IsValid(j.kind()), field + ".kind",
          "is missing; BALL, HINGE, SLIDER or FIXED");
  const auto body = [&](const std::string& name) -> const proto::Body* {
    for (const proto::Body& b : s.message.bodies())
      if (b.name() == name) return &b;
    return nullptr;
  };
  const proto::Body *first = body(j.first()), *second = body(j.second());
  if (!first) refuse_name(s, field + ".first", j.first(), "body", names_in(s.message.bodies()));
  s.check(!first->is_static() && !first->has_half_space(), field + ".first",
          "'{}' is static; name a body that moves first", j.first());
  if (!j.second().empty() && !second)
    refuse_name(s, field + ".second", j.second(), "body", names_in(s.message.bodies()),
                "name one, or leave it out for the world");
  s.check(j.first() != j.second(), field + ".second", "is '{}' as well; a joint is between two bodies", j.second());
  for (const auto& [name, v] : {std::pair{".position", &j.position()}, std::pair{".axis", &j.axis()}})
    s.check(std::isfinite(v->x()) && std::isfinite(v->y()) && std::isfinite(v->z()), field + name,
            "is ({}, {}, {}), must be finite", v->x(), v->y(), v->z());
  const bool turned = j.kind() == proto::BodyJoint::HINGE || j.kind() == proto::BodyJoint::SLIDER;
  s.check(!j.has_axis() || turned, field + ".axis", "is for a HINGE or a SLIDER; leave it out");
  s.check(!j.has_axis() || to_vec(j.axis()).norm() > 1e-9, field + ".axis", "has no direction");
  if (!j.has_breaks()) return;
  const proto::JointBreak& b = j.breaks();
  const std::string f = field + ".breaks";
  s.check(b.has_time_s() || b.has_angle_deg() || b.has_extension_m(), f,
          "says nothing; give time_s, angle_deg or extension_m, or leave it out");
  s.check(!b.has_time_s() || (std::isfinite(b.time_s()) && b.time_s() > 0.0), f + ".time_s",
          "is {} s, must be positive", b.time_s());
  s.check(!b.has_angle_deg() || j.kind() == proto::BodyJoint::HINGE || j.kind() == proto::BodyJoint::BALL,
          f + ".angle_deg", "is for a HINGE or a BALL, which let bodies turn; leave it out");
  s.check(!b.has_angle_deg() || (b.angle_deg() > 0.0 && b.angle_deg() < 180.0), f + ".angle_deg",
          "is {}; above 0, below 180 degrees", b.angle_deg());
  s.check(!b.has_extension_m() || j.kind() == proto::BodyJoint::SLIDER, f + ".extension_m",
          "is for a SLIDER, which lets bodies slide; leave it out");
  s.check(!b.has_extension_m() || (std::isfinite(b.extension_m()) && b.extension_m() > 0.0), f + ".extension_m",
          "is {} m, must be positive", b.extension_m());
}

void seams(const LoadedScene& s) {
  const proto::Seams& m = s.message.seams();
  s.check(!m.has_tolerance_m() || (m.tolerance_m() > 0.0 && m.tolerance_m() <= 1.0), "seams.tolerance_m",
          "is {} m; above 0, at most 1", m.tolerance_m());
  std::set<std::pair<std::string, std::string>> pairs;
  for (int i = 0; i < m.rules_size(); ++i) {
    const proto::SeamRule& r = m.rules(i);
    const std::string f = fmt::format("seams.rules[{}]", i);
    for (const auto& [name, field] : {std::pair{r.first(), ".first"}, std::pair{r.second(), ".second"}})
      if (!is_shell(s.message, name)) refuse_name(s, f + field, name, "shell", names_in(s.message.shells()));
    s.check(r.first() != r.second(), f + ".second", "is '{}' as well; a seam is between two shells", r.second());
    s.check(pairs.insert(std::minmax(r.first(), r.second())).second, f, "says again how '{}' and '{}' hang together",
            r.first(), r.second());
    if (!r.has_strength()) continue;
    positive(s, f + ".strength", true, r.strength(), "N/m");
    s.check(r.kind() != proto::SeamRule::OPEN, f + ".strength",
            "is given, and kind is OPEN, which joins nothing; leave one of them out");
    s.check(s.message.coupling().scheme() != proto::Coupling::ITERATED, f + ".strength",
            "is given, and coupling.scheme is ITERATED, which would open the seam in a pass that is repeated; take "
            "PROXY or EXPORTED");
  }
}

}  // namespace

void validate_coupling(const LoadedScene& s) {
  const proto::Scene& m = s.message;
  std::set<std::string> names;
  for (int i = 0; i < m.joints_size(); ++i) joint(s, fmt::format("joints[{}]", i), m.joints(i), names);
  seams(s);
  const proto::Coupling& c = m.coupling();
  if (c.has_export_above()) {
    s.check(c.scheme() == proto::Coupling::PROXY, "coupling.export_above", "is for scheme PROXY; leave it out");
    s.check(c.export_above() > 0.0, "coupling.export_above", "is {}, must be positive", c.export_above());
  }
  if (c.has_iterations()) {
    s.check(c.scheme() == proto::Coupling::ITERATED, "coupling.iterations", "is for scheme ITERATED; leave it out");
    s.check(c.iterations() >= 1 && c.iterations() <= kMostIterations, "coupling.iterations", "is {}; 1 to {}",
            c.iterations(), kMostIterations);
  }
  if (!c.has_adaptive_window()) return;
  const proto::AdaptiveWindow& a = c.adaptive_window();
  s.check(!a.has_tolerance() || (a.tolerance() > 0.0 && a.tolerance() < 1.0), "coupling.adaptive_window.tolerance",
          "is {}; a share of the energy, above 0 and below 1", a.tolerance());
  if (!a.has_shortest_window_s()) return;
  const double halvings = std::log2(m.window_s() / a.shortest_window_s());
  s.check(a.shortest_window_s() > 0.0 && halvings >= 1.0 - 1e-9 && halvings <= kMostHalvings &&
              std::abs(halvings - std::round(halvings)) < 1e-6,
          "coupling.adaptive_window.shortest_window_s",
          "is {} s; must be window_s, {} s, over a power of two, as {:.6g} s is", a.shortest_window_s(), m.window_s(),
          m.window_s() / std::exp2(std::clamp(std::round(halvings), 1.0, kMostHalvings)));
}

}  // namespace sunder::scene
