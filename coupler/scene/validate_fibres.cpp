// Checks fibres through the thickness of shells.
#include <cmath>

#include "coupler/scene/checks.h"

namespace sunder::scene {
namespace {

constexpr double kMostFriction = 1e6;
constexpr double kMostPressure = 0.81;  // of the compression modulus: fibres end at a tenth of their length

const proto::Shell* with_fibres(const LoadedScene& s, const std::string& name) {
  for (const proto::Shell& shell : s.message.shells())
    if (shell.name() == name && shell.has_fibres()) return &shell;
  return nullptr;
}

// Damage of fibres, which is there where a shear strength is given.
void damage(const LoadedScene& s, const std::string& f, const proto::Shell& shell) {
  const proto::Fibres& m = shell.fibres();
  const double most = kMostPressure * m.compression_modulus(), friction = m.has_friction() ? m.friction() : 0.5;
  if (m.has_crushing_strength()) {
    s.check(m.has_shear_strength(), f + ".crushing_strength",
            "needs a shear_strength, from which the softening of fibres follows; give one, or leave it out");
    positive(s, f + ".crushing_strength", true, m.crushing_strength(), "Pa");
    s.check(m.crushing_strength() < most, f + ".crushing_strength",
            "is {} Pa, and fibres end under {:.4g} compression_modulus, {:.4g} Pa; take less, or leave it out",
            m.crushing_strength(), kMostPressure, most);
  }
  if (!m.has_shear_strength()) return;
  positive(s, f + ".shear_strength", true, m.shear_strength(), "Pa");
  s.check(m.has_crushing_strength() || m.shear_strength() < friction * most, f + ".shear_strength",
          "is {} Pa, and layers slide at {:.4g} Pa under the highest pressure that fibres bear; take less, or raise "
          "friction or compression_modulus",
          m.shear_strength(), friction * most);
  s.check(s.message.fracture().mode() == proto::Fracture::DAMAGE, f + ".shear_strength",
          "needs fracture {{ mode: DAMAGE }}, in which cracks follow from damage; give that, or leave it out");
  s.check(any_material_of(s.message, shell, [](const proto::Material& q) { return q.has_strength(); }),
          f + ".shear_strength",
          "needs a material with a strength and a fracture_energy, which '{}' has not; give it both, or leave it out",
          shell.material());
}

void shell(const LoadedScene& s, const std::string& at, const proto::Shell& shell) {
  const std::string f = at + ".fibres";
  const proto::Fibres& m = shell.fibres();
  positive(s, f + ".compression_modulus", m.has_compression_modulus(), m.compression_modulus(), "Pa");
  positive(s, f + ".shear_modulus", m.has_shear_modulus(), m.shear_modulus(), "Pa");
  not_negative(s, f + ".friction", m.has_friction(), m.friction());
  s.check(m.friction() <= kMostFriction, f + ".friction", "is {}; at most {:g}, which holds whatever is pressed",
          m.friction(), kMostFriction);
  s.check(!m.has_grid_spacing_m() || (std::isfinite(m.grid_spacing_m()) && m.grid_spacing_m() > 0.0),
          f + ".grid_spacing_m", "is {}; must be positive [m]", m.grid_spacing_m());
  damage(s, f, shell);
  for (const proto::Material& q : s.message.materials()) {
    if (q.name() != shell.material()) continue;
    s.check(!q.has_stiffness_damping_s(), f,
            "exclude stiffness_damping_s, which material '{}' has; take mass_damping_per_s, or leave one of them out",
            q.name());
  }
  bool others = s.message.shells_size() > 1;  // a shell with fibres to touch: another one, or itself by a contact pair
  if (others) {
    int count = 0;
    for (const proto::Shell& q : s.message.shells()) count += q.has_fibres() ? 1 : 0;
    others = count > 1;
  }
  for (const proto::ContactPair& c : s.message.contacts())
    others = others || (c.first() == shell.name() && c.second() == shell.name());
  s.check(others, f,
          "have nothing to touch; give fibres to another shell, let this one touch itself by contacts {{ first: \"{}\" "
          "second: \"{}\" }}, or leave them out",
          shell.name(), shell.name());
}

}  // namespace

void validate_fibres(const LoadedScene& s) {
  const proto::Scene& m = s.message;
  bool any = false;
  for (int i = 0; i < m.shells_size(); ++i) {
    if (!m.shells(i).has_fibres()) continue;
    any = true;
    shell(s, fmt::format("shells[{}]", i), m.shells(i));
  }
  if (!any) return;
  for (int i = 0; i < m.contacts_size(); ++i) {
    const proto::ContactPair& c = m.contacts(i);
    if (!with_fibres(s, c.first()) || !with_fibres(s, c.second())) continue;
    s.check(!c.has_friction() && !c.has_restitution(), fmt::format("contacts[{}]", i),
            "is between shells with fibres, which have their own friction and are elastic; leave friction and "
            "restitution out");
  }
  s.check(m.transfer().kind() == proto::GridTransfer::DIRECT, "transfer",
          "cannot go with fibres, whose forces act on control points; leave one of them out");
  s.check(!m.fracture().has_latest_freeze_s(), "fracture.latest_freeze_s",
          "would freeze the shells before end_time_s, while their fibres still carry forces; leave it out");
  s.check(m.coupling().scheme() != proto::Coupling::ITERATED, "coupling.scheme",
          "is ITERATED, which fibres exclude; take another scheme");
}

}  // namespace sunder::scene
